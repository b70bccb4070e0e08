"""Flies a long mission in a process of its own and tells what grew and what drifted.

python -m tests.soak.six_hours [OUT [DURATION_S]]

Memory is sampled with every line that the launch prints, some seconds apart; the rest is read out
of the recording afterwards.
"""

import json
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil

from uavbridge.agent.report import decode
from uavbridge.bus.messages import decode_truth
from uavbridge.recording.reader import Recording

MISSION = Path(__file__).with_suffix(".toml")
TICK_US = 100_000
_TIME = re.compile(r"^(?:(\d+):)?(\d+):(\d\d) min")


@dataclass(frozen=True)
class Flight:
    """What was sampled while it flew."""

    wall_s: float
    cpu_s: float  # what it takes on a core of its own
    status: int
    samples: np.ndarray  # (k, 3) mission time s, wall time s, resident memory in MB


@dataclass(frozen=True)
class Drift:
    """What its recording says, by hour of the mission where there are several numbers."""

    duration_s: float
    states: frozenset[str]
    failures: tuple[str, ...]
    parts: tuple[float, ...]  # MB of each
    complete: bool
    ticks: int  # true positions, one a control tick
    odd_steps: int  # of them not a tick after the one before
    reports: frozenset[int]  # how many agents made, one a second
    decisions: tuple[int, int]  # fewest and most of an agent, one a second of search
    believed_m: tuple[float, ...]  # largest distance between reported and true position
    flown_km: tuple[float, ...]  # way of whoever flew least
    landed_m: float  # farthest landing from its start
    closest_m: float


def fly(out: Path, duration_s: float | None = None) -> Flight:
    """Fly it, sampling."""
    command = [sys.executable, "-m", "uavbridge", "launch", str(MISSION), "--headless"]
    command += ["--out", str(out)]
    if duration_s is not None:
        command += ["--duration", str(duration_s)]
    began = time.monotonic()
    samples, cpu_s = [], 0.0
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        process = psutil.Process(child.pid)
        assert child.stdout is not None
        for line in child.stdout:
            found = _TIME.match(line)
            if found is None:
                continue
            hours, minutes, seconds = (int(part or 0) for part in found.groups())
            wall_s, octets = time.monotonic() - began, process.memory_info().rss
            samples.append((3600.0 * hours + 60.0 * minutes + seconds, wall_s, octets / 1e6))
            cpu_s = sum(process.cpu_times()[:2])
            if len(samples) % 12 == 0:
                print(
                    f"  {line.split(',')[0]}: {cpu_s:.0f} CPU s, {octets / 1e6:.1f} MB", flush=True
                )
    wall_s = time.monotonic() - began
    return Flight(wall_s, cpu_s, child.returncode, np.array(samples).reshape(-1, 3))


def slope_mb_per_hour(samples: np.ndarray, after_s: float, until_s: float) -> float:
    """Growth of memory per mission hour between two mission times, by least squares."""
    at = samples[(samples[:, 0] >= after_s) & (samples[:, 0] <= until_s)]
    return float(np.polyfit(at[:, 0] / 3600.0, at[:, 2], 1)[0])


def speeds(samples: np.ndarray) -> list[float]:
    """Mission seconds per second in each hour of the mission that was flown whole."""
    hours = np.arange(0.0, samples[-1, 0] + 1.0, 3600.0)
    at = np.interp(hours, samples[:, 0], samples[:, 1])
    return (3600.0 / np.diff(at)).tolist()


def drift(out: Path) -> Drift:
    """Read the recording and the summary."""
    summary = json.loads((out / "summary.json").read_text())
    recording = Recording(out)
    last_us, ticks, odd = -TICK_US, 0, 0
    reports: Counter[int] = Counter()
    decisions: Counter[int] = Counter()
    believed: dict[int, float] = {}
    odometers: dict[int, dict[int, float]] = {-1: {}}  # by hour and agent, m
    first: dict[int, np.ndarray] = {}
    where: dict[int, np.ndarray] = {}
    for topic, t_us, data in recording.messages():
        kind, _, agent = topic.partition("/")
        if kind == "truth":
            truth = decode_truth(data)
            ticks, odd, last_us = ticks + 1, odd + (t_us != last_us + TICK_US), t_us
            where = dict(zip(truth.ids, truth.position, strict=True))
            first = first or where
        elif kind == "decision":
            decisions[int(agent)] += 1
        elif kind == "state":
            report = decode(data)
            reports[report.agent] += 1
            odometers.setdefault(t_us // 3_600_000_000, {})[report.agent] = report.distance_m
            if report.in_air and report.agent in where:
                off_m = float(np.linalg.norm(where[report.agent] - np.array(report.position)))
                hour = t_us // 3_600_000_000
                believed[hour] = max(believed.get(hour, 0.0), off_m)
    return Drift(
        duration_s=summary["duration_s"],
        states=frozenset(agent["state"] for agent in summary["agents"]),
        failures=tuple(summary["failures"]),
        parts=tuple(path.stat().st_size / 1e6 for path in recording.parts.values()),
        complete=recording.complete,
        ticks=ticks,
        odd_steps=odd,
        reports=frozenset(reports.values()),
        decisions=(min(decisions.values()), max(decisions.values())),
        believed_m=tuple(believed[hour] for hour in sorted(believed)),
        flown_km=tuple(
            min(odometers[hour][a] - odometers[hour - 1].get(a, 0.0) for a in first) / 1e3
            for hour in sorted(odometers)[1:]
        ),
        landed_m=max(float(np.hypot(*(where[a] - first[a])[:2])) for a in first),
        closest_m=summary["min_separation_m"],
    )


def main(out: Path, duration_s: float | None) -> None:
    flight = fly(out, duration_s)
    print(f"status {flight.status}, {flight.wall_s:.0f} s, {flight.cpu_s:.0f} s of CPU")
    print("x real time, by hour:", [round(x, 1) for x in speeds(flight.samples)])
    end_s = flight.samples[-1, 0]
    for share in (1 / 3, 1 / 2):
        slope = slope_mb_per_hour(flight.samples, share * end_s, end_s)
        print(f"memory after {share:.0%} of the mission: {slope:+.2f} MB an hour")
    found = drift(out)
    for name, value in vars(found).items():
        print(f"{name:12} {value}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else None)
    else:
        with tempfile.TemporaryDirectory() as folder:
            main(Path(folder) / "flight", None)
