"""Step responses measured from samples at 10 Hz, as for recorded flights."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

BANDS = {"position": 0.5, "velocity": 0.25, "yaw": 2.0}  # m, m/s, deg


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
