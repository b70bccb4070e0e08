"""A folder in which place agents keep their tiles: one file each, whole or not at all.

A file belongs to one run of the mission, which is named in its first 8 bytes: another run does
not see it.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, MutableMapping
from pathlib import Path

from uavbridge.errors import ConfigError

_RUN_BYTES = 8

_log = logging.getLogger(__name__)


class Store(MutableMapping[int, bytes]):
    """Tiles by place agent.

    Args:
        folder: made when it is not there.
        run: of the mission, not negative.

    Attributes:
        run: whose tiles are read and written.

    Raises:
        ConfigError: it cannot be written to.
    """

    def __init__(self, folder: Path, run: int = 0) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / ".writable").touch()
            (folder / ".writable").unlink()
        except OSError as fault:
            raise ConfigError(f"--store: cannot write to {folder}: {fault.strerror}") from None
        self.run = run
        self._folder = folder
        self._fails = False

    def __getitem__(self, place: int) -> bytes:
        try:
            data = self._file(place).read_bytes()
        except OSError:
            raise KeyError(place) from None
        if data[:_RUN_BYTES] != self._mark():
            raise KeyError(place)
        return data[_RUN_BYTES:]

    def __setitem__(self, place: int, tile: bytes) -> None:
        """Write a tile. Where that fails the old one stays, and there is one warning."""
        new = self._folder / f"place-{place}.new"
        try:
            new.write_bytes(self._mark() + tile)
            new.replace(self._file(place))
        except OSError as fault:
            if not self._fails:
                _log.warning("%s: not written: %s", self._file(place), fault.strerror)
            self._fails = True

    def __delitem__(self, place: int) -> None:
        self._file(place).unlink()

    def __iter__(self) -> Iterator[int]:
        names = (path.stem.removeprefix("place-") for path in self._folder.glob("place-*.tile"))
        places = sorted(int(name) for name in names if name.isdigit())
        return (place for place in places if self.get(place) is not None)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _mark(self) -> bytes:
        return self.run.to_bytes(_RUN_BYTES, "little")

    def _file(self, place: int) -> Path:
        return self._folder / f"place-{place}.tile"
