"""What the simulated vehicles do when told what those of the recorded flights were told.

Step by step with the measures of the flights' summary: ArduCopter and ArduRover 4.6.3 SITL, PX4
1.17 SIH. ``python tests/sim_vehicles/fleet/test_recorded_steps.py`` prints the table of
docs/reference/simulator.md.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isnan, nan

import numpy as np
import pytest

from sim_vehicles.fleet import Fleet, VehicleSpec
from tests.sim_vehicles.conftest import ORIGIN, Station
from tests.sim_vehicles.dynamics.test_step_responses import Samples, measure

MEASURES = ("delay", "rise", "t90", "overshoot", "settling", "peak", "tilt", "steady")
NORTH, EAST, UP = 1, 0, 2


@dataclass(frozen=True)
class Phase:
    """A step: NED m or m/s, how long, along which axis; and what was measured, as MEASURES."""

    kind: str
    asked: tuple[float, float, float]
    seconds: float
    axis: int
    theirs: tuple[float, ...]
    yaw_deg: float | None = None


@dataclass(frozen=True)
class Flight:
    """One recorded flight."""

    autopilot: str
    kind: str
    phases: dict[str, Phase] = field(default_factory=dict)


FLIGHTS = {
    "ArduCopter": Flight(
        "ardupilot",
        "multirotor",
        {
            "30 m north": Phase(
                "position", (30, 0, -10), 20, NORTH,
                (0.31, 4.35, 6.23, 0.67, 9.33, 6.68, 27.0, nan),
            ),
            "30 m east": Phase(
                "position", (30, 30, -10), 20, EAST,
                (0.31, 4.36, 6.23, 0.65, 9.35, 6.71, 27.1, nan),
            ),
            "5 m/s north": Phase(
                "velocity", (5, 0, 0), 8, NORTH,
                (0.30, 1.78, 2.33, 0.12, 2.91, 5.12, 20.2, 5.05),
            ),
            "stop": Phase(
                "velocity", (0, 0, 0), 5, NORTH,
                (0.29, 1.71, 2.26, 0.10, 2.56, 5.02, 12.5, 0.07),
            ),
            "10 m up": Phase(
                "position", (70, 30, -20), 15, UP,
                (0.27, 4.13, 5.69, 0.02, 6.22, 2.54, 0.2, nan),
            ),
            "5 m down": Phase(
                "position", (70, 30, -15), 12, UP,
                (0.27, 2.96, 4.12, 0.03, 4.12, 1.57, 0.2, nan),
            ),
        },
    ),
    "PX4 SIH": Flight(
        "px4",
        "multirotor",
        {
            "30 m north": Phase(
                "position", (30, 0, -10), 19.8, NORTH,
                (0.15, 3.17, 4.40, 1.16, 11.14, 8.60, 44.9, nan),
            ),
            "30 m east": Phase(
                "position", (30, 30, -10), 19.8, EAST,
                (0.16, 3.22, 4.49, 1.49, nan, 8.72, 44.9, nan),
            ),
            "5 m/s north": Phase(
                "velocity", (5, 0, 0), 7.9, NORTH,
                (0.14, nan, nan, 0.0, nan, 4.46, 35.5, 4.38),
            ),
            "stop": Phase(
                "velocity", (0, 0, 0), 5, NORTH,
                (0.16, nan, nan, 0.0, nan, 4.45, 22.2, 0.62),
            ),
            "10 m up": Phase(
                "position", (70, 30, -20), 14.9, UP,
                (0.05, 3.20, 3.87, 0.18, 4.32, 2.86, 3.1, nan),
            ),
            "5 m down": Phase(
                "position", (70, 30, -15), 11.9, UP,
                (0.06, 3.02, 3.61, 0.40, 3.61, 1.43, 4.9, nan),
            ),
        },
    ),
    "ArduRover": Flight(
        "ardupilot",
        "rover",
        {
            "30 m north": Phase(
                "position", (30, 0, 0), 25, NORTH,
                (0.79, 6.79, 9.92, 0.46, 11.48, 4.59, nan, nan),
            ),
            "30 m east": Phase(
                "position", (30, 30, 0), 30, EAST,
                (1.25, 6.71, 10.03, 0.30, 11.67, 4.78, nan, nan),
            ),
            "3 m/s north": Phase(
                "velocity", (3, 0, 0), 12, NORTH,
                (1.02, 1.41, 2.63, 0.47, 4.56, 3.47, nan, 3.00),
            ),
            "stop": Phase(
                "velocity", (0, 0, 0), 5, NORTH,
                (0.37, 1.99, 2.64, 0.46, 4.60, 3.00, nan, 0.33),
            ),
            "3 m/s east": Phase(
                "velocity", (0, 3, 0), 10, EAST,
                (0.80, 1.57, 2.65, 0.44, 4.58, 3.44, nan, 3.01),
            ),
            "stop again": Phase(
                "velocity", (0, 0, 0), 5, EAST,
                (0.35, 1.02, 1.57, 0.07, 4.61, 3.00, nan, 0.34),
            ),
        },
    ),
}  # fmt: skip


def fly(flight: Flight) -> dict[str, dict[str, float]]:
    """The measures of every phase, of ours."""
    spec = VehicleSpec(1, (0.0, 0.0, 0.0), kind=flight.kind, autopilot=flight.autopilot)
    gcs = Station(Fleet([spec], origin=ORIGIN))
    gcs.get_ready()
    if flight.autopilot == "px4":
        gcs.stream = lambda: gcs.setpoint((0, 0, -10))
        gcs.fly(0.5)
        assert gcs.mode_to(6) == gcs.arm() == 0
        gcs.fly(25)
    else:
        assert gcs.mode_to(4 if flight.kind == "multirotor" else 15) == gcs.arm() == 0
        if flight.kind == "multirotor":
            gcs.fly(1)
            assert gcs.command(22, 0, 0, 0, nan, 0, 0, 10) == 0
            gcs.fly(15)
    return {name: _measured(gcs, phase) for name, phase in flight.phases.items()}


def _measured(gcs: Station, phase: Phase) -> dict[str, float]:
    velocity = phase.kind == "velocity"
    states, rows = gcs.fleet.states, []
    gcs.stream = lambda: gcs.setpoint(
        None if velocity else phase.asked, phase.asked if velocity else None
    )
    for k in range(round(phase.seconds * 10) + 1):
        place, speed = states.position[0, phase.axis], states.velocity[0, phase.axis]
        lean = np.degrees([states.roll[0], states.pitch[0]])
        tilt = np.degrees(np.arccos(np.cos(states.roll[0]) * np.cos(states.pitch[0])))
        rows.append((0.1 * k, speed if velocity else place, speed, tilt, *lean))
        gcs.fly(0.1)
    table = np.array(rows)
    north, east, down = phase.asked
    target = (east, north, -down)[phase.axis]
    found = measure(Samples(*table[:, :4].T, table[:, 4:]), phase.kind, target)
    return found | {"steady": abs(found["final"]) if velocity else nan}


def table() -> list[str]:
    """Recorded and ours, as lines of a Markdown table."""
    lines = [
        "| flight | step | " + " | ".join(MEASURES) + " |",
        "| --- | --- |" + " --- |" * len(MEASURES),
    ]
    for name, flight in FLIGHTS.items():
        for step, ours in fly(flight).items():
            theirs = flight.phases[step].theirs
            pairs = zip(theirs, (ours[each] for each in MEASURES), strict=True)
            lines.append(
                f"| {name} | {step} | " + " | ".join(_pair(*pair) for pair in pairs) + " |"
            )
    return lines


def _pair(theirs: float, ours: float) -> str:
    texts = ["not" if isnan(value) else f"{round(value, 2):.3g}" for value in (theirs, ours)]
    return "-" if texts == ["not", "not"] else ", ".join(texts)


# How far ours are off at most: s, s, s, m or m/s, s, m/s, degrees, m/s. Overshoot and settling:
# no more than so much worse.
OFF = {
    "ArduCopter": (0.21, 0.6, 1.1, 0.2, 1.0, 1.0, 4.0, 0.1),
    "PX4 SIH": (0.06, 1.0, 1.5, 0.05, 0.5, 1.2, 19.0, 0.7),
    "ArduRover": (0.95, 1.4, 1.1, 0.05, 0.5, 0.6, 1.0, 0.4),
}
BETTER_BELOW = ("overshoot", "settling")


@pytest.mark.parametrize("name", FLIGHTS)
def test_steps_are_as_far_off_as_the_page_says(name):
    for step, ours in fly(FLIGHTS[name]).items():
        theirs = FLIGHTS[name].phases[step].theirs
        for measured, real, most in zip(MEASURES, theirs, OFF[name], strict=True):
            off = ours[measured] - real
            off = max(off, 0.0) if measured in BETTER_BELOW else abs(off)
            assert isnan(off) or off <= most, (step, measured, ours[measured], real)


# ArduPlane 4.6.3: what was measured, and how far off ours may be.
PLANE = {
    "take-off: 45 m up after, s": (8.3, 4.5),
    "take-off: fastest climb, m/s": (10.7, 3.0),
    "300 m north: bank begins after, s": (0.27, 0.4),
    "300 m north: 120 m from it after, s": (7.7, 2.5),
    "loiter: distance, m": (96.2, 20.0),
    "loiter: ground speed, m/s": (23.4, 2.5),
    "loiter: bank, degrees": (37.8, 10.0),
    "400 m east, 30 m up: 120 m from it after, s": (10.4, 3.5),
    "400 m east, 30 m up: 10 to 90 % of the climb, s": (8.0, 4.0),
    "400 m east, 30 m up: fastest climb, m/s": (4.5, 3.0),
}


NORTH_M, EAST_M = (0.9, 298.4), (342.3, -77.0)  # of where it was: 510 north, 77 west, and so on


def fly_plane() -> dict[str, float]:
    """The same of ours."""
    spec = VehicleSpec(1, (0.0, 0.0, 0.0), kind="plane", autopilot="ardupilot")
    gcs = Station(Fleet([spec], origin=ORIGIN))
    gcs.get_ready()
    assert gcs.mode_to(13) == gcs.arm() == 0
    up = _watched(gcs, 12.0, (0.0, 0.0))
    north = _repositioned(gcs, *NORTH_M, 50.0, 48.0)
    loiter = north[north["t"] > 36.0]
    assert gcs.mode_to(15) == 0
    east = _repositioned(gcs, *EAST_M, 80.0, 31.0)
    climb = east["z"] - east["z"][0]
    found = (
        _first(up, up["z"] >= 45.0),
        up["vz"].max(),
        _first(north, np.abs(north["bank"] - north["bank"][0]) > 5.0),
        _first(north, north["away"] < 120.0),
        loiter["away"].mean(),
        loiter["speed"].mean(),
        np.abs(loiter["bank"]).mean(),
        _first(east, east["away"] < 120.0),
        _first(east, climb > 27.0) - _first(east, climb > 3.0),
        east["vz"].max(),
    )
    return dict(zip(PLANE, map(float, found), strict=True))


def _repositioned(gcs: Station, x: float, y: float, height: float, seconds: float) -> np.ndarray:
    """Sent to a place, m east and north of where it is, and watched."""
    here = gcs.position
    x, y = x + float(here[0]), y + float(here[1])
    latitude = round((ORIGIN.latitude_deg + y / 111_186.0) * 1e7)
    longitude = round((ORIGIN.longitude_deg + x / 75_395.0) * 1e7)
    assert gcs.command_int(192, -1, 1, 0, 0, frame=3, x=latitude, y=longitude, z=height) == 0
    return _watched(gcs, seconds, (x, y))


def _watched(gcs: Station, seconds: float, about: tuple[float, float]) -> np.ndarray:
    names = ("t", "z", "vz", "speed", "bank", "away")
    states, rows = gcs.fleet.states, []
    for k in range(round(seconds * 10)):
        (x, y, z), (vx, vy, vz) = states.position[0], states.velocity[0]
        away = np.hypot(x - about[0], y - about[1])
        bank = np.degrees(states.roll[0])
        rows.append((0.1 * k, z, vz, np.hypot(vx, vy), bank, away))
        gcs.fly(0.1)
    return np.array(rows, dtype=[(name, float) for name in names])


def _first(samples: np.ndarray, true: np.ndarray) -> float:
    return float(samples["t"][true][0]) if true.any() else inf


def test_a_plane_is_as_far_off_as_the_page_says():
    ours = fly_plane()
    off = {name: (ours[name], real) for name, (real, most) in PLANE.items()
           if abs(ours[name] - real) > most}  # fmt: skip
    assert not off


def plane_table() -> list[str]:
    """ArduPlane's, as lines of a Markdown table."""
    rows = [f"| {name} | {PLANE[name][0]:.3g} | {ours:.3g} |" for name, ours in fly_plane().items()]
    return ["| ArduPlane | recorded | ours |", "| --- | --- | --- |", *rows]


if __name__ == "__main__":
    print("\n".join([*table(), "", *plane_table()]))
