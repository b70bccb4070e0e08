"""Cost of deciding for a flock of aircraft: python tests/benchmarks/bench_planners.py."""

from __future__ import annotations

import time

import numpy as np

from planners.grid import Grid
from planners.planner import Planner
from planners.search.starling import STARLING, StarlingParams
from planners.types import F64, Limits, Neighbours, Scenario, View
from sim_vehicles.dynamics import Setpoints
from sim_vehicles.dynamics.plane import GuidedPlane
from uavbridge.experiments.chen import flight, terrains

SIZES = (8, 12, 20)
TICK_S = 0.2
SECONDS = 30.0
SENSING_M = 3000.0


def flown(count: int) -> tuple[float, float]:
    """CPU seconds a second of flight, and of the longest single decision."""
    ground, grid = terrains.terrain("one"), Grid(-300.0, -1350.0, 100.0, 86, 28)
    position, velocity = flight.start(count, np.random.default_rng(1))
    limits = Limits(60.0, 12.0, 25.0, 300.0)
    team = tuple(range(1, count + 1))
    case = Scenario(grid, team, position.copy(), TICK_S, limits)
    planner: Planner = STARLING.bind(case, StarlingParams(lead_s=1.0))
    model = GuidedPlane(position, np.zeros(count), airspeed=np.minimum(velocity[:, 0], 65.0))
    setpoints = Setpoints.idle(count)
    setpoints.motors[:] = True
    memories, payloads = [None] * count, [b""] * count
    spent, longest = 0.0, 0.0
    belief, seen = np.zeros(grid.shape), np.zeros(grid.shape, dtype=np.bool_)
    rng, calm = np.random.default_rng(5), np.zeros((count, 3))
    for tick in range(round(SECONDS / TICK_S)):
        position, velocity = model.states.position.copy(), model.states.velocity.copy()
        told = list(payloads)
        for row in range(count):
            heard = _heard(row, position, velocity, payloads)
            heading = float(model.states.yaw[row])
            view = View(
                round(tick * TICK_S * 1e6), tick, row + 1, position[row], velocity[row], heading,
                heard, belief, seen, terrain=ground.around(position[row], SENSING_M),
            )  # fmt: skip
            begin = time.process_time()
            if tick == 0:
                memories[row] = planner.init(view)
            goal, memories[row] = planner.plan(view, memories[row], rng)
            took = time.process_time() - begin
            spent, longest = spent + took, max(longest, took)
            setpoints.velocity[row], told[row] = goal.setpoint.velocity, goal.payload
        payloads = told
        for _ in range(round(TICK_S / 0.02)):
            model.step(setpoints, calm, 0.02)
    return spent / SECONDS, longest


def _heard(row: int, position: F64, velocity: F64, payloads: list[bytes]) -> Neighbours:
    others = [other for other in range(len(position)) if other != row]
    return Neighbours(
        np.array(others) + 1,
        position[others],
        velocity[others],
        np.full(len(others), 0.1),
        tuple(payloads[other] for other in others),
    )


def main() -> None:
    print(f"starling, {1.0 / TICK_S:g} decisions a second: CPU s a second of flight, longest one")
    for count in SIZES:
        share, longest = flown(count)
        print(f"{count:4} aircraft  {share:6.3f} s  {longest * 1e3:6.1f} ms")


if __name__ == "__main__":
    main()
