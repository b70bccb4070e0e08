"""Missions on terrain in words: what a check says, and what the live view shows."""

from __future__ import annotations

from uavbridge import config
from uavbridge.check import understood
from uavbridge.monitor.screen import one_line, screen
from uavbridge.monitor.snapshot import Snapshot
from uavbridge.runner.snapshot import facts_of


def test_a_check_tells_of_the_ground_and_who_drives() -> None:
    lines = understood(config.load("zhou2023-rovers")).lines()
    words = "ground    generated; heights 0 to 161 m, slopes up to 40.0 degrees, 4.6% above beta"
    assert words in lines
    assert "search    by the targets' signals, time limit 1500 s" in lines
    assert "    1  start x 7 m, y 7 m; a rover, searches on the ground" in lines


def test_nobody_who_hears_signals_is_shown_coverage() -> None:
    facts = facts_of(config.load("zhou2023-multirotors"))
    now = Snapshot(t_s=60.0, declared=3)
    assert one_line(facts, now, factor=2.0).startswith("1:00 min, targets 3/10, closest pair")
    shown = [line.plain for line in screen(facts, now, factor=2.0, width=80, height=24)]
    assert any(line.strip() == "targets   3 of 10 found" for line in shown)
    assert not any("coverage" in line or "entropy" in line for line in shown)
    flat = facts_of(config.load())
    assert "coverage 0%, entropy" in one_line(flat, now, factor=2.0)
