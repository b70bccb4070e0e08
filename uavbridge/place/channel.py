"""The emulated radio between UAVs and place agents: one message, one receiver."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from planners.types import F64, I64, Bools
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.channel import Channel, Verdicts
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.truth import TruthTrack
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
    """

    _what = "place message"

    def __init__(
        self,
        bus: Bus,
        radio: Radio,
        ids: Sequence[int],
        tiling: Tiling,
        truth: TruthTrack | None = None,
    ) -> None:
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
    def _number(message: Said) -> int:
        return message.t_us
