"""Six mission hours in lockstep; ten minutes of real time with a hundred vehicles."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.soak import six_hours

pytestmark = [pytest.mark.soak, pytest.mark.timeout(5400)]

HUNDRED = Path(__file__).with_name("hundred.toml")
DURATION_S = 6 * 3600.0
LATE_SHARE = 0.01


def test_six_hours_with_fifty_vehicles(tmp_path):
    flight = six_hours.fly(tmp_path / "flight")
    assert flight.cpu_s < 3600.0
    # after two hours, when every cell is known and the report's series have their full length
    assert six_hours.slope_mb_per_hour(flight.samples, 7200.0, DURATION_S) < 2.0
    first, *_, last = six_hours.speeds(flight.samples)
    assert last > 0.5 * first
    found = six_hours.drift(tmp_path / "flight")
    assert found.duration_s >= DURATION_S
    assert found.states == {"landed"}
    assert found.failures == ()
    assert found.ticks == round(10.0 * found.duration_s) + 1
    assert found.odd_steps == 0
    assert found.reports == {round(found.duration_s) + 1}
    assert found.decisions[0] > DURATION_S - 60.0
    assert max(found.believed_m) < 3.0
    assert min(found.flown_km[:6]) > 2.0  # nobody lies about with an empty battery
    assert found.landed_m < 2.0
    assert found.closest_m > 10.0
    assert len(found.parts) > 5
    assert max(found.parts) < 80.0
    assert found.complete


def test_ten_minutes_with_a_hundred_vehicles_in_real_time(tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-m", "uavbridge", "launch", HUNDRED, "--headless"]
    done = subprocess.run([*command, "--out", out], capture_output=True, text=True, check=False)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["duration_s"] >= 600.0, done.stdout
    assert summary["ticks"] >= 6000
    assert summary["late_ticks"] <= LATE_SHARE * summary["ticks"]
    assert {agent["state"] for agent in summary["agents"]} == {"landed"}
    assert summary["failures"] == []
