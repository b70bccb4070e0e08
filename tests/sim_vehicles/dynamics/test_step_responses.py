"""The default multirotor against recorded flights of ArduCopter 4.6.3 SITL and PX4 1.17 SIH.

``python tests/sim_vehicles/dynamics/test_step_responses.py`` prints the table of
docs/reference/vehicle_model.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from sim_vehicles.dynamics import Multirotor, Setpoints

BANDS = {"position": 0.5, "velocity": 0.25, "yaw": 2.0}  # m, m/s, deg
STEP_S = 0.02
HEIGHT = 15.0

# phase: (kind, setpoint, seconds, axis)
PHASES = {
    "takeoff": ("position", (0.0, 0.0, 10.0), 14.0, 2),
    "step_north_30": ("position", (0.0, 30.0, HEIGHT), 20.0, 1),
    "step_east_30": ("position", (30.0, 0.0, HEIGHT), 20.0, 0),
    "vel_north_5": ("velocity", (0.0, 5.0, 0.0), 8.0, 1),
    "vel_zero": ("velocity", (0.0, 0.0, 0.0), 5.0, 1),
    "climb_10": ("position", (0.0, 0.0, HEIGHT + 10.0), 15.0, 2),
    "descend_5": ("position", (0.0, 0.0, HEIGHT - 5.0), 12.0, 2),
    "yaw_90": ("yaw", (90.0, 0.0, 0.0), 10.0, 0),
}


# Recorded flights of (ArduCopter 4.6.3 SITL, PX4 1.17 SIH), no wind; None: not reached.
# Times s, then m, m/s, m/s2 and deg. PX4's take-off holds on the ground before it climbs.
REFERENCE: dict[str, dict[str, tuple[float, float | None]]] = {
    "takeoff": {
        "delay": (1.52, 3.88),
        "rise": (4.18, 6.30),
        "t90": (6.97, 11.99),
        "overshoot": (0.01, 0.27),
        "settling": (7.50, 12.56),
        "peak": (2.53, 1.49),
        "gain": (4.02, 0.94),
        "loss": (0.71, 1.40),
    },
    "step_north_30": {
        "delay": (0.31, 0.15),
        "delay_lean": (0.12, 0.08),
        "rise": (4.35, 3.17),
        "t90": (6.23, 4.40),
        "overshoot": (0.67, 1.16),
        "settling": (9.33, 11.14),
        "peak": (6.68, 8.60),
        "tilt": (27.0, 44.9),
        "gain": (2.78, 6.02),
        "loss": (2.03, 4.59),
    },
    "step_east_30": {
        "delay": (0.31, 0.16),
        "delay_lean": (0.12, 0.04),
        "rise": (4.36, 3.22),
        "t90": (6.23, 4.49),
        "overshoot": (0.65, 1.49),
        "settling": (9.35, None),
        "peak": (6.71, 8.72),
        "tilt": (27.1, 44.9),
        "gain": (2.80, 5.47),
        "loss": (2.02, 4.91),
    },
    "vel_north_5": {
        "delay": (0.30, 0.14),
        "delay_lean": (0.12, 0.04),
        "rise": (1.78, None),
        "t90": (2.33, None),
        "overshoot": (0.12, 0.0),
        "settling": (2.91, None),
        "peak": (5.12, 4.46),
        "tilt": (20.2, 35.5),
        "gain": (2.78, 5.20),
        "final": (5.05, 4.38),
    },
    "vel_zero": {
        "delay": (0.29, 0.16),
        "delay_lean": (0.12, 0.09),
        "rise": (1.71, None),
        "t90": (2.26, None),
        "overshoot": (0.10, 0.0),
        "settling": (2.56, None),
        "tilt": (12.5, 22.2),
        "gain": (2.65, 5.56),
        "final": (0.07, 0.62),
    },
    "climb_10": {
        "delay": (0.27, 0.05),
        "rise": (4.13, 3.20),
        "t90": (5.69, 3.87),
        "overshoot": (0.02, 0.18),
        "settling": (6.22, 4.32),
        "peak": (2.54, 2.86),
        "gain": (1.14, 7.06),
        "loss": (0.71, 2.04),
    },
    "descend_5": {
        "delay": (0.27, 0.06),
        "rise": (2.96, 3.02),
        "t90": (4.12, 3.61),
        "overshoot": (0.03, 0.40),
        "settling": (4.12, 3.61),
        "peak": (1.57, 1.43),
        "gain": (1.14, 4.00),
        "loss": (0.70, 1.22),
    },
    "yaw_90": {
        "delay_lean": (0.22, 0.14),
        "rise": (1.11, 0.59),
        "t90": (1.56, 0.91),
        "overshoot": (3.9, 15.0),
        "settling": (2.29, 2.98),
        "peak": (70.7, 137.1),
        "gain": (167.0, 295.0),
    },
}
SHARE = 0.15  # of the nearer flight's value, allowed outside the two
READING = {"delay": 0.05, "delay_lean": 0.05, "rise": 0.1, "t90": 0.1}  # s: of 10 Hz samples
BETTER_BELOW = ("overshoot", "settling")  # no worse than the worse one is what counts


@dataclass(frozen=True, eq=False)
class Samples:
    """One phase at 10 Hz from the command on, along the axis of its step."""

    time_s: np.ndarray
    value: np.ndarray  # m, m/s or deg: what steps
    speed: np.ndarray  # m/s along the axis; deg/s of a yaw step
    tilt_deg: np.ndarray
    lean_deg: np.ndarray  # (k, 2) roll, pitch; of a yaw step yaw in both


def _crossing(time: np.ndarray, value: np.ndarray, level: float) -> float:
    """When ``value`` first reaches ``level``, between samples; NaN: never."""
    above = np.flatnonzero(value >= level)
    if not len(above):
        return np.nan
    k = above[0]
    if k == 0:
        return float(time[0])
    share = (level - value[k - 1]) / (value[k] - value[k - 1])
    return float(time[k - 1] + share * (time[k] - time[k - 1]))


def measure(samples: Samples, kind: str, target: float) -> dict[str, float]:
    """Measures of a step of ``kind`` to ``target``; NaN: not reached."""
    time, start = samples.time_s, samples.value[0]
    sign = np.sign(target - start)
    step = abs(target - start)
    done = sign * (samples.value - start)
    speed = sign * samples.speed
    lean = np.abs(samples.lean_deg - samples.lean_deg[0]).max(axis=1)
    outside = np.flatnonzero(np.abs(done - step) > BANDS[kind])
    last = outside[-1] if len(outside) else -1
    slope = np.array([(b - a) for a, b in pairwise(speed)]) / np.diff(time)
    return {
        "delay": _crossing(time, np.abs(speed - speed[0]), 0.1),
        "delay_lean": _crossing(time, lean, 1.0),
        "rise": _crossing(time, done, 0.9 * step) - _crossing(time, done, 0.1 * step),
        "t90": _crossing(time, done, 0.9 * step),
        "overshoot": max(0.0, float(done.max() - step)),
        "settling": float(time[last + 1]) if last + 1 < len(time) else np.nan,
        "peak": float(np.abs(samples.speed).max()),
        "tilt": float(samples.tilt_deg.max()),
        "gain": float(slope.max()),
        "loss": float(-slope.min()),
        "final": float(samples.value[time > time[-1] - 2.0].mean()),
    }


def fly(phase: str, step_s: float = STEP_S) -> dict[str, float]:
    """Measure the default multirotor in ``phase``."""
    kind, target, seconds, axis = PHASES[phase]
    grounded = phase == "takeoff"
    model = Multirotor(np.array([[0.0, 0.0, 0.0 if grounded else HEIGHT]]), np.zeros(1))
    setpoints = Setpoints.idle(1)
    setpoints.motors[:] = True
    if phase == "vel_zero":
        setpoints.velocity[:] = PHASES["vel_north_5"][1]
        for _ in range(round(8.0 / step_s)):
            model.step(setpoints, np.zeros((1, 3)), step_s)
    if kind == "velocity":
        setpoints.velocity[:] = target
    elif kind == "position":
        setpoints.position[:] = target
        setpoints.max_up[:] = 2.0 if grounded else np.inf  # between 1.5 and 2.5 m/s
    else:
        setpoints.position[:] = 0.0, 0.0, HEIGHT
        setpoints.yaw[:] = np.radians(target[0])

    states, rows = model.states, []
    every = round(0.1 / step_s)
    for k in range(round(seconds / step_s) + 1):
        if k % every == 0:
            yaw = np.degrees(states.yaw[0])
            tilt = np.arccos(np.cos(states.roll[0]) * np.cos(states.pitch[0]))
            lean = (yaw, yaw) if kind == "yaw" else np.degrees([states.roll[0], states.pitch[0]])
            place = yaw if kind == "yaw" else states.position[0, axis]
            speed = np.degrees(states.rates[0, 2]) if kind == "yaw" else states.velocity[0, axis]
            value = speed if kind == "velocity" else place
            rows.append((k * step_s, value, speed, np.degrees(tilt), *lean))
        model.step(setpoints, np.zeros((1, 3)), step_s)
    table = np.array(rows)
    return measure(Samples(*table[:, :4].T, table[:, 4:]), kind, target[axis])


def table() -> list[str]:
    """The comparison, as lines of a Markdown table."""
    lines = [
        "| phase | measure | ArduCopter | PX4 SIH | multirotor |",
        "| --- | --- | --- | --- | --- |",
    ]
    for phase, measures in REFERENCE.items():
        ours = fly(phase)
        for name, pair in measures.items():
            texts = ["not" if value is None else f"{value:.2f}" for value in pair]
            lines.append(f"| {phase} | {name} | {texts[0]} | {texts[1]} | {ours[name]:.2f} |")
    return lines


@pytest.mark.parametrize("phase", PHASES)
def test_step_response_lies_between_the_recorded_autopilots(phase):
    ours = fly(phase)
    outside = {}
    for name, pair in REFERENCE[phase].items():
        known = [value for value in pair if value is not None]
        reading = READING.get(name, 0.0)
        low = min(known) * (1.0 - SHARE) - reading
        high = max(known) * (1.0 + SHARE) + reading
        if name in BETTER_BELOW:
            low = 0.0
            high = np.inf if None in pair else high
        if not low <= ours[name] <= high:
            outside[name] = (ours[name], pair)
    assert not outside


@pytest.mark.parametrize("step_s", [0.005, 0.01, 0.04])
def test_another_step_gives_nearly_the_same_response(step_s):
    for phase in ("step_east_30", "vel_north_5", "climb_10"):
        usual, other = fly(phase), fly(phase, step_s)
        for name in ("rise", "t90", "peak", "tilt", "final"):
            assert other[name] == pytest.approx(usual[name], rel=0.03, abs=0.05), (phase, name)


if __name__ == "__main__":
    print("\n".join(table()))
