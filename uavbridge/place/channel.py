"""The emulated radio between UAVs and place agents: one message, one receiver."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from planners.types import F64, I64, Bools
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.channel import Channel, Verdicts
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.truth import TruthTrack
from uavbridge.bus.wire import WAITED_LIMIT_S
from uavbridge.clock import SECOND_US
from uavbridge.place.wire import Said, decode_said, encode_said
from uavbridge.radio import Radio, Verdict


class PlaceAir(Channel[Said]):
    """The radio of UAVs and place agents. Others do not hear what is not for them.

    Args:
        bus: the mission's.
        radio: that of the agents.
        ids: of the agents, or place agents, in this process.
        tiling: of the keys.
        truth: true positions of the vehicles.
        tick_us: between two decisions of an agent: at most one word a tick, and one answer.
    """

    _what = "place message"

    def __init__(
        self,
        bus: Bus,
        radio: Radio,
        ids: Sequence[int],
        tiling: Tiling,
        truth: TruthTrack | None = None,
        *,
        tick_us: int = 1,
    ) -> None:
        self._tick_us = tick_us
        super().__init__(bus, radio, ids, tiling, truth)
        self._meant: Bools = np.zeros((0, len(self.agents)), np.bool_)

    def _judge(self, batch: list, known: F64, t_us: int) -> Verdicts:  # type: ignore[type-arg]
        to = np.array([arrival.message.to for arrival in batch])
        self._meant = np.asarray(to[:, None] == self._ids)
        return super()._judge(batch, known, t_us)

    def _count(self, verdicts: Verdicts, size: I64) -> None:
        verdicts[~self._meant] = Verdict.OWN
        super()._count(verdicts, size)

    @staticmethod
    def _key(tile: keys.TilePattern, agent: int | str) -> str:
        return keys.place(tile, agent)

    @staticmethod
    def _encode(message: Said) -> bytes:
        return encode_said(message)

    @staticmethod
    def _decode(data: bytes, rejects: Counter[str]) -> Said | None:
        return decode_said(data, rejects)

    @staticmethod
    def _waited(message: Said, waited_s: float) -> Said:
        return replace(message, waited_s=min(waited_s, WAITED_LIMIT_S))

    @staticmethod
    def _left_us(message: Said) -> float:
        return message.t_us + message.waited_s * SECOND_US

    def _number(self, message: Said) -> int:
        return message.t_us // self._tick_us  # a burst lasts as long as for frames
