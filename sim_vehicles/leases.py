"""Ports and system ids that simulators of one machine have taken, so that no two take the same.

A lease is a lock on a small file in the machine's folder for temporary files. The kernel lets
go of it when its process ends, however it ends.
"""

from __future__ import annotations

import errno
import fcntl
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from sim_vehicles.ports import BASE_PORT, NETWORK, Seat, ServerError, seats

FOLDER: Final = "uavbridge-leases"
_LAST_BASE: Final = 16000  # no further up are ports looked for
_BUSY: Final = (errno.EACCES, errno.EAGAIN)


class Leases:
    """What this process holds; kept until ``close`` or its end.

    Args:
        folder: where the files are; None: the machine's.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = folder or Path(tempfile.gettempdir()) / FOLDER
        self._files: dict[str, int] = {}

    def take(self, names: Iterable[str]) -> bool:
        """Take all of these, or none.

        Raises:
            ServerError: the folder can not be written to.
        """
        taken: dict[str, int] = {}
        for name in names:
            held = self._lock(name)
            if held is None:
                for opened in taken.values():
                    os.close(opened)
                return False
            taken[name] = held
        self._files |= taken
        return True

    def _lock(self, name: str) -> int | None:
        try:
            self._folder.mkdir(mode=0o1777, parents=True, exist_ok=True)
            opened = os.open(self._folder / name, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise ServerError(f"{self._folder}: {error.strerror}") from error
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(opened)
            if error.errno in _BUSY:
                return None
            raise ServerError(f"{self._folder / name}: {error.strerror}") from error
        os.ftruncate(opened, 0)
        os.write(opened, f"{os.getpid()}\n".encode())
        return opened

    def close(self) -> None:
        """Let go of everything."""
        for opened in self._files.values():
            os.close(opened)
        self._files.clear()


def lease_seats(
    count: int, leases: Leases, *, each: bool | None = None, start_system: int | None = None
) -> tuple[Seat, ...]:
    """Seats that no other simulator of this machine has, the lowest ports and ids first.

    Args:
        count: vehicles.
        leases: hold what was taken.
        each: a port for each vehicle; None: up to ten vehicles.
        start_system: system id of the first vehicle; None: the first of a row that is free.

    Raises:
        ValueError: there are not so many ids.
        ServerError: no ports, or no ids, are left.
    """
    first = start_system or _free_systems(count, leases)
    for base in range(BASE_PORT, _LAST_BASE):
        found = seats(count, each=each, base=base, start_system=first)
        if leases.take(f"port-{port}" for port in sorted({seat.port for seat in found})):
            return found
    raise ServerError(f"no ports from {BASE_PORT} on are left for {count} vehicles")


def _free_systems(count: int, leases: Leases) -> int:
    if count > NETWORK:  # they are used again anyway
        return 1
    for first in range(1, NETWORK - count + 2):
        if leases.take(f"system-{number}" for number in range(first, first + count)):
            return first
    raise ServerError(f"no {count} system ids in a row are left on this machine")
