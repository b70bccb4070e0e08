"""Shao 2020, Figs 4(a), 5(a) and 6(a): five targets on 50 x 50 cells."""

from __future__ import annotations

from uavbridge.experiments.shao import detect
from uavbridge.experiments.shao.detect import DetectParams

EXPERIMENT = detect.experiment(
    "shao-detect-50", 50, DetectParams, __file__, tuple(range(0, 3001, 50))
)
