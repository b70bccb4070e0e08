"""A folder in which place agents keep their tiles: one file each, whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from pathlib import Path

from uavbridge.errors import ConfigError


class Store(MutableMapping[int, bytes]):
    """Tiles by place agent.

    Args:
        folder: made when it is not there.

    Raises:
        ConfigError: it cannot be written to.
    """

    def __init__(self, folder: Path) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as fault:
            raise ConfigError(f"--store: cannot write to {folder}: {fault.strerror}") from None
        self._folder = folder

    def __getitem__(self, place: int) -> bytes:
        try:
            return self._file(place).read_bytes()
        except FileNotFoundError:
            raise KeyError(place) from None

    def __setitem__(self, place: int, tile: bytes) -> None:
        new = self._folder / f"place-{place}.new"
        new.write_bytes(tile)
        new.replace(self._file(place))

    def __delitem__(self, place: int) -> None:
        self._file(place).unlink()

    def __iter__(self) -> Iterator[int]:
        names = (path.stem.removeprefix("place-") for path in self._folder.glob("place-*.tile"))
        return iter(sorted(int(name) for name in names if name.isdigit()))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _file(self, place: int) -> Path:
        return self._folder / f"place-{place}.tile"
