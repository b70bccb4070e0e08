"""The built-in mission in lockstep, ten vehicles: python tests/benchmarks/bench_mission.py [ROUNDS]

Each row is a process of its own, measured with all it starts, imports included: CPU seconds
(user and system) and "x real time", mission seconds per CPU second: what one core can do. The
rows are flown in turns, and the best round of each counts, as other programs disturb it least.

    simulator alone     the same ten vehicles in the air for as long, streams on, nobody listens
    mission             agents, planners, bus, radio, safety, digest; nothing is written
    recorded, reported  the same with mission.mcap, ten .tlog files, summary and report
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic
from uavbridge import config
from uavbridge.runner.launch import fly, fly_and_report

GOAL = 30.0  # x real time, for the last row
SEED = 7
STEP_US = 100_000
ROWS = ("simulator alone", "mission", "recorded, reported")


def hover(seconds: float) -> float:
    """Ten vehicles on their starts; the time that they flew."""
    mission = config.load(None, {})
    specs = [
        VehicleSpec(member.id, (*member.start, 0.0), in_air_m=member.altitude_m)
        for member in mission.team()
    ]
    fleet = Fleet(specs, origin=Geodetic(47.397742, 8.545594, 488.0), seed=SEED)
    while fleet.now_us < seconds * 1e6:
        fleet.advance(fleet.now_us + STEP_US)
        fleet.transmit()
    assert all(fleet.truth().in_air)
    return fleet.now_us / 1e6


def run(row: str, seconds: float) -> float:
    """One row, in this process; mission seconds flown."""
    if row == "simulator alone":
        return hover(seconds)
    mission = config.load(None, {"clock": "stepped", "seed": SEED, "headless": True})
    if row == "mission":
        return fly(mission, folder=None).duration_s
    with tempfile.TemporaryDirectory() as folder:
        result = fly_and_report(mission, Path(folder))
    assert not result.failures, result.failures
    return result.duration_s


def measure(row: str, seconds: float) -> tuple[float, float, float]:
    """Mission seconds, CPU seconds and wall seconds of one row in a process of its own."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, __file__, "--row", row, str(seconds)]
    done = subprocess.run(command, capture_output=True, check=True)
    wall = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return float(json.loads(done.stdout.splitlines()[-1])), used, wall


def main(rounds: int) -> None:
    best: dict[str, tuple[float, float, float]] = {}
    seconds = 400.0
    for _ in range(rounds):
        for row in reversed(ROWS):  # the mission first: it says how long the simulator flies
            flown, used, wall = measure(row, seconds)
            seconds = flown
            if row not in best or used < best[row][1]:
                best[row] = flown, used, wall
    print(f"{'':20}{'mission s':>10}{'CPU s':>9}{'x real time':>13}{'x wall':>9}{'to alone':>10}")
    alone = best[ROWS[0]][1]
    for row in ROWS:
        flown, used, wall = best[row]
        goal = ""
        if row == ROWS[-1]:
            goal = f"  goal x{GOAL:g}: {'met' if flown / used >= GOAL else 'MISSED'}"
        print(
            f"{row:20}{flown:10.1f}{used:9.2f}{flown / used:13.1f}{flown / wall:9.1f}"
            f"{used / alone:10.1f}{goal}"
        )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--row"]:
        print(run(sys.argv[2], float(sys.argv[3])))
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
