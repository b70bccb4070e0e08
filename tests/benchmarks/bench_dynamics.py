"""Microseconds a step of each vehicle model: python tests/benchmarks/bench_dynamics.py."""

from __future__ import annotations

import time

import numpy as np

from sim_vehicles.crafts import CRAFTS
from sim_vehicles.dynamics import Setpoints, Wind, WindSpec

SIZES = (1, 10, 100, 1000)
STEP_S = 0.02
MODELS = {
    name: model
    for kind in ("multirotor", "plane")
    for name, model in CRAFTS["px4", kind].models.items()
}
BEST_OF = 7
OTHERS = ("perfect", "six-dof", "guidance")


def cost_us(name: str, n: int, gusts: float) -> float:
    """Best mean cost of a step, flying to far positions."""
    start = np.zeros((n, 3))
    start[:, 2] = 20.0
    model = MODELS[name](start, np.zeros(n))
    setpoints = Setpoints.idle(n)
    setpoints.position[:] = start + np.array([300.0, 100.0, 10.0])
    setpoints.yaw[:] = 1.0
    setpoints.motors[:] = True
    wind = Wind(WindSpec(gust_m_s=gusts), n, 0)
    best = np.inf
    for _ in range(BEST_OF):
        begin = time.perf_counter()
        for _ in range(200):
            model.step(setpoints, wind.step(STEP_S), STEP_S)
        best = min(best, (time.perf_counter() - begin) / 200)
    return best * 1e6


def main() -> None:
    print("us a step" + "".join(f"{f'n = {n}':>10}" for n in SIZES))
    for name, gusts in (
        ("multirotor", 0.0),
        ("multirotor", 2.0),
        *((each, 0.0) for each in OTHERS),
    ):
        figures = "".join(f"{cost_us(name, n, gusts):10.1f}" for n in SIZES)
        print(f"{name}{' in gusts' if gusts else ''}".ljust(20) + figures)


if __name__ == "__main__":
    main()
