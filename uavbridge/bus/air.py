"""The two emulated radios of a process: the planners' ``air/`` and the ``safety/`` beacon."""

from __future__ import annotations

from collections import Counter

from uavbridge.bus import keys
from uavbridge.bus.channel import Channel
from uavbridge.bus.wire import Beacon, Frame, decode, decode_beacon, encode, encode_beacon


class Air(Channel[Frame]):
    """The radio over which agents exchange frames; all a planner knows of the others."""

    @staticmethod
    def _key(tile: keys.TilePattern, agent: int | str) -> str:
        return keys.air(tile, agent)

    @staticmethod
    def _encode(message: Frame) -> bytes:
        return encode(message)

    @staticmethod
    def _decode(data: bytes, rejects: Counter[str]) -> Frame | None:
        return decode(data, rejects)

    @staticmethod
    def _number(message: Frame) -> int:
        return message.tick


class SafetyBeacons(Channel[Beacon]):
    """The short-range position beacon for separation, with its own range and accounts."""

    @staticmethod
    def _key(tile: keys.TilePattern, agent: int | str) -> str:
        return keys.safety(tile, agent)

    @staticmethod
    def _encode(message: Beacon) -> bytes:
        return encode_beacon(message)

    @staticmethod
    def _decode(data: bytes, rejects: Counter[str]) -> Beacon | None:
        return decode_beacon(data, rejects)

    @staticmethod
    def _number(message: Beacon) -> int:
        return message.t_us
