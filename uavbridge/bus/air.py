"""The two emulated radios of a process: the planners' ``air/`` and the ``safety/`` beacon."""

from __future__ import annotations

from msgspec.structs import replace

from uavbridge.bus import keys
from uavbridge.bus.channel import Channel
from uavbridge.bus.traffic import Traffic
from uavbridge.bus.wire import (
    WAITED_BYTES,
    WAITED_LIMIT_S,
    Beacon,
    Frame,
    decode,
    decode_beacon,
    encode,
    encode_beacon,
)
from uavbridge.clock import SECOND_US


class Air(Channel[Frame]):
    """The radio over which agents exchange frames; all a planner knows of the others."""

    _what = "frame"
    _waited_bytes = WAITED_BYTES

    @staticmethod
    def _note(message: Frame, traffic: Traffic) -> None:
        traffic.map_bytes_sent += message.map_bytes

    @staticmethod
    def _waited(message: Frame, waited_s: float) -> Frame:
        return replace(message, waited_s=min(waited_s, WAITED_LIMIT_S))

    @staticmethod
    def _left_us(message: Frame) -> float:
        return message.t_us + message.waited_s * SECOND_US

    @staticmethod
    def _key(tile: keys.TilePattern, agent: int | str) -> str:
        return keys.air(tile, agent)

    _encode = staticmethod(encode)
    _decode = staticmethod(decode)

    @staticmethod
    def _number(message: Frame) -> int:
        return message.tick


class SafetyBeacons(Channel[Beacon]):
    """The short-range position beacon for separation, with its own range and accounts."""

    _what = "beacon"

    @staticmethod
    def _key(tile: keys.TilePattern, agent: int | str) -> str:
        return keys.safety(tile, agent)

    _encode = staticmethod(encode_beacon)
    _decode = staticmethod(decode_beacon)

    @staticmethod
    def _number(message: Beacon) -> int:
        return message.t_us
