"""What is measured of a flight, and its tracks as a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from planners.flocking.starling import behaviours, goals
from planners.flocking.starling.wing import parts
from planners.terrain import Terrain
from planners.types import F64
from uavbridge.errors import ConfigError
from uavbridge.experiments.chen.flight import STEP_S, Tracks

LINK_M = 120.0  # aircraft nearer than that are one group: R_maxl and the danger extension
SETTLED_S = 5.0
EVERY_S = 5.0  # of the curves


def numbers(tracks: Tracks, terrain: Terrain) -> dict[str, float]:
    """The figures of one flight."""
    settled = tracks.t_s > SETTLED_S
    apart = goals.separation(tracks.position)
    above = tracks.position[..., 2] - terrain.height_at(tracks.position)
    speed, course, climb = parts(tracks.velocity)
    count = goals.groups(tracks.position[::10], LINK_M)
    end = tracks.velocity[-1]
    shares = {
        f"share_{name}": float((tracks.mode == number).mean())
        for number, name in enumerate(behaviours.NAMES)
    }
    return {
        "min_separation_m": float(apart[settled].min()),
        "min_separation_start_m": float(apart[~settled].min()),
        "min_clearance_m": float(above.min()),
        "groups_end": float(count[-1]),
        "groups_most": float(count.max()),
        "speed_end_m_s": float(speed[-1].mean()),
        "yaw_end_rad": float(np.angle(np.exp(1j * course[-1]).mean())),
        "pitch_end_rad": float(-climb[-1].mean()),
        "polarisation_end": float(goals.polarisation(end)),
        "speed_spread_end_m_s": float(goals.speed_spread(end)),
        "cohesion_end_m": float(goals.cohesion(tracks.position[-1])),
        "yaw_least_rad": float(course.min()),
        "yaw_most_rad": float(course.max()),
        "pitch_least_rad": float(-climb.max()),
        "pitch_most_rad": float(-climb.min()),
        "speed_least_m_s": float(speed.min()),
        "speed_most_m_s": float(speed.max()),
        **shares,
        "share_danger": float(tracks.danger.mean()),
    }


def curves(tracks: Tracks) -> dict[str, F64]:
    """Eq. (1) over time: (k,) each, every ``EVERY_S``."""
    stride = round(EVERY_S / STEP_S)
    position, velocity = (part[stride - 1 :: stride] for part in (tracks.position, tracks.velocity))
    return {
        "polarisation": goals.polarisation(velocity),
        "speed_spread_m_s": goals.speed_spread(velocity),
        "cohesion_m": goals.cohesion(position),
        "separation_m": goals.separation(position),
    }


def write_csv(t_s: F64, position: F64, velocity: F64, path: Path) -> None:
    """Tracks (k, n, 3) at times (k,) as t, id, x, y, z, vx, vy, vz; SI, z up, ids from 1.

    Raises:
        ConfigError: the file cannot be written.
    """
    lines = ["t,id,x,y,z,vx,vy,vz"]
    for now, places, paces in zip(t_s, position, velocity, strict=True):
        for who, (place, pace) in enumerate(zip(places, paces, strict=True), start=1):
            figures = ",".join(f"{value:.3f}" for value in (*place, *pace))
            lines.append(f"{now:.1f},{who},{figures}")
    try:
        path.write_text("\n".join(lines) + "\n")
    except OSError as error:
        raise ConfigError(f"tracks={path}: {error.strerror}") from error


def beside(path: Path, *parts_of_name: object) -> Path:
    """FILE with something more in its name: for the cases after the first."""
    extra = "-".join(str(part) for part in parts_of_name)
    return path.with_name(f"{path.stem}-{extra}{path.suffix}")
