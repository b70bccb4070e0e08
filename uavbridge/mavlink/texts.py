"""STATUSTEXT to whole texts: long ones come in chunks of fifty bytes."""

from __future__ import annotations

from typing import Any, NamedTuple

_CHUNK_BYTES = 50
_GAP = "[...]"  # a chunk was lost


class _Parts(NamedTuple):
    severity: int
    chunks: dict[int, str]


class Texts:
    """Joins the texts of one vehicle; one text is open at a time for each component."""

    def __init__(self) -> None:
        self._open: dict[int, tuple[int, _Parts]] = {}
        self._finished: dict[int, int] = {}

    def hear(self, message: Any, component: int) -> list[tuple[int, str]]:
        """Take a STATUSTEXT: (severity, text) of each text that is whole now."""
        if message.id == 0:
            return [(message.severity, message.text.strip())]
        if self._finished.get(component) == message.id:  # a doubled datagram
            return []
        whole = []
        opened = self._open.get(component)
        if opened is not None and opened[0] != message.id:  # its end was lost
            whole.append(self._close(component))
            opened = None
        if opened is None:
            opened = self._open[component] = (message.id, _Parts(message.severity, {}))
        opened[1].chunks[message.chunk_seq] = message.text
        if len(message.text.encode()) < _CHUNK_BYTES:
            whole.append(self._close(component))
        return whole

    def _close(self, component: int) -> tuple[int, str]:
        number, parts = self._open.pop(component)
        self._finished[component] = number
        chunks = [parts.chunks.get(index, _GAP) for index in range(max(parts.chunks) + 1)]
        return parts.severity, "".join(chunks).strip()
