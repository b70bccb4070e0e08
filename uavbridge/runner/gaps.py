"""When an onlooker has missed frames: agents say what is new once, and nobody asks for him."""

from __future__ import annotations

from uavbridge.clock import to_us

AGAIN_S = 10.0  # between two requests for whole maps


class Gaps:
    """Watches the ticks of all senders."""

    def __init__(self) -> None:
        self._ticks: dict[int, int] = {}
        self._missed = False
        self._next_us = 0

    def note(self, sender: int, tick: int) -> None:
        """A frame was heard."""
        before = self._ticks.get(sender)
        self._missed |= before is not None and tick > before + 1
        self._ticks[sender] = max(tick, before or 0)

    def due(self, t_us: int) -> bool:
        """Whether whole maps should be asked for now; the next time only after new gaps."""
        if not self._missed or t_us < self._next_us:
            return False
        self._missed, self._next_us = False, t_us + to_us(AGAIN_S)
        return True
