"""Landings in an autopilot's mission: looked for, uploaded, taken away, over lossy links."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest

from sim_vehicles.codec import Counts, Encoder, decode, mav
from sim_vehicles.geodesy import Geodetic, to_enu
from uavbridge.mavlink.landings import APPROACH_M, HEIGHT_M, Landings, Runway

HOME = Geodetic(47.4, 8.5, 488.0)
START, CIRCLE, LAND, POINT = 189, 31, 21, 16
Rows = list[tuple[int, float, int, int, float]]  # command, param1, x, y, z


class Autopilot:
    """A mission store as ArduPilot's: it asks for items one by one, and is stateless to readers."""

    def __init__(self, items: Rows, lose: float = 0.0) -> None:
        self.items = items
        self.landings = Landings(Encoder(245, 190), 1, lambda: Runway(HOME, pi / 2))
        self.verdicts: list[tuple[bool, str]] = []
        self.requests = "MISSION_REQUEST"
        self.refuses = 0
        self._rng, self._lose = np.random.default_rng(1), lose
        self._encoder = Encoder(1)
        self._incoming: Rows = []
        self._expected = 0

    def run(self, seconds: float = 60.0) -> None:
        t_us = asked_us = 0
        while self.landings.busy and t_us < seconds * 1e6:
            t_us += 100_000
            answers = []
            for frame in self.landings.due(t_us):
                answers += self._answers(decode(frame, Counts())[0].message)
            if answers:
                asked_us = t_us
            elif len(self._incoming) < self._expected and t_us - asked_us >= 1_000_000:
                asked_us = t_us
                answers = [self._pack(self.requests, seq=len(self._incoming))]
            for answer in answers:
                if self._rng.random() >= self._lose:
                    self.landings.hear(decode(answer, Counts())[0].message, t_us)
        self.verdicts += [(v.accepted, v.reason) for v in self.landings.take()]

    def _answers(self, message: Any) -> list[bytes]:
        if self._rng.random() < self._lose:
            return []
        match message.msgname:
            case "MISSION_REQUEST_LIST":
                return [self._pack("MISSION_COUNT", count=len(self.items))]
            case "MISSION_REQUEST_INT":
                command, p1, x, y, z = self.items[message.seq]
                return [self._pack("MISSION_ITEM_INT", seq=message.seq, frame=3, command=command,
                                   current=0, autocontinue=1, param1=p1, param2=0, param3=0,
                                   param4=0, x=x, y=y, z=z)]  # fmt: skip
            case "MISSION_COUNT":
                self._incoming, self._expected = [], message.count
                return [self._pack(self.requests, seq=0)]
            case "MISSION_ITEM_INT" if message.seq == len(self._incoming):
                self._incoming.append(
                    (message.command, message.param1, message.x, message.y, message.z)
                )
                if len(self._incoming) < self._expected:
                    return [self._pack(self.requests, seq=len(self._incoming))]
                if not self.refuses:
                    self.items = self._incoming
                return [self._pack("MISSION_ACK", type=self.refuses)]
            case "MISSION_CLEAR_ALL":
                self.items = []
                return [self._pack("MISSION_ACK", type=0)]
        return []

    def _pack(self, name: str, **fields: int) -> bytes:
        return self._encoder.pack(
            name, target_system=245, target_component=190, mission_type=0, **fields
        )


@pytest.mark.parametrize("request_name", ["MISSION_REQUEST", "MISSION_REQUEST_INT"])
@pytest.mark.parametrize("lose", [0.0, 0.3])
@pytest.mark.parametrize("before", [[], [(POINT, 0.0, 1, 1, 0.0)]])
def test_a_landing_is_uploaded_where_there_is_none(
    before: Rows, lose: float, request_name: str
) -> None:
    autopilot = Autopilot(before, lose)
    autopilot.requests = request_name
    autopilot.landings.provide(0)
    autopilot.run()
    assert autopilot.verdicts == [(True, "")]
    assert [item[0] for item in autopilot.items] == [POINT, START, CIRCLE, LAND]
    _, _, x, y, z = autopilot.items[2]
    assert z == HEIGHT_M
    west = to_enu(x * 1e-7, y * 1e-7, 488.0, HOME)
    np.testing.assert_allclose(west[:2], (-APPROACH_M, 0.0), atol=0.1)
    _, _, x, y, z = autopilot.items[3]
    assert (x, y, z) == (474_000_000, 85_000_000, 0.0)
    autopilot.landings.remove(0)
    autopilot.run()
    assert autopilot.items == []


def test_an_operators_landing_serves_and_stays() -> None:
    theirs = [(POINT, 0.0, 1, 1, 0.0), (START, 0.0, 0, 0, 0.0), (CIRCLE, 0.0, 1, 1, 50.0),
              (LAND, 0.0, 2, 2, 0.0)]  # fmt: skip
    autopilot = Autopilot(list(theirs))
    autopilot.landings.provide(0)
    autopilot.run()
    autopilot.landings.remove(0)
    autopilot.run()
    assert autopilot.verdicts == [(True, ""), (True, "")]
    assert autopilot.items == theirs


def test_a_mission_without_a_landing_is_left_alone() -> None:
    theirs = [(POINT, 0.0, 1, 1, 0.0), (POINT, 0.0, 2, 2, 50.0)]
    autopilot = Autopilot(list(theirs))
    autopilot.landings.provide(0)
    autopilot.run()
    assert autopilot.verdicts == [(False, "its mission has no landing (DO_LAND_START)")]
    assert autopilot.items == theirs


def test_refusals_and_silence_say_so() -> None:
    autopilot = Autopilot([])
    autopilot.refuses = int(mav.MAV_MISSION_NO_SPACE)
    autopilot.landings.provide(0)
    autopilot.run()
    assert autopilot.verdicts == [(False, "landing: no_space")]
    silent = Autopilot([], lose=1.0)
    silent.landings.provide(0)
    silent.run()
    assert silent.verdicts == [(False, "landing: no answer (count)")]
