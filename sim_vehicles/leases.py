"""Ports and system ids that simulators of one machine have taken, so that no two take the same.

A lease is a lock on a small file in the machine's folder for temporary files. The kernel lets
go of it when its process ends, however it ends.
"""

from __future__ import annotations

import errno
import fcntl
import os
import tempfile
from collections.abc import Collection, Iterable
from contextlib import suppress
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

    def note(self, names: Iterable[str]) -> None:
        """Take those that nobody has, if that can be: somebody asked for them by number."""
        with suppress(ServerError):
            for name in names:
                self.take([name])

    def holder(self, name: str) -> str:
        """Who has a name, for messages: "pid 123", or "another process"."""
        with suppress(OSError, ValueError):
            return f"pid {int((self._folder / name).read_text())}"
        return "another process"

    def _lock(self, name: str) -> int | None:
        try:
            opened = self._open(self._folder / name)
        except OSError as error:
            raise ServerError(f"{self._folder}: {error.strerror}") from error
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(opened)
            if error.errno in _BUSY:
                return None
            raise ServerError(f"{self._folder / name}: {error.strerror}") from error
        with suppress(OSError):  # another user's file: it is locked, if not written to
            os.ftruncate(opened, 0)
            os.write(opened, f"{os.getpid()}\n".encode())
        return opened

    def _open(self, path: Path) -> int:
        """A file of the folder; both are for all users of the machine."""
        with suppress(FileExistsError):
            self._folder.mkdir(parents=True)
            self._folder.chmod(0o1777)
        try:
            opened = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except PermissionError:
            return os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        with suppress(PermissionError):
            os.fchmod(opened, 0o666)
        return opened

    def close(self) -> None:
        """Let go of everything."""
        for opened in self._files.values():
            os.close(opened)
        self._files.clear()


def lease_seats(
    count: int,
    leases: Leases,
    *,
    each: bool | None = None,
    port: int | None = None,
    start_system: int | None = None,
) -> tuple[Seat, ...]:
    """Seats that no other simulator of this machine has, the lowest ports and ids first.

    What is asked for by number is given, whoever has it, and kept from those who do not ask.

    Args:
        count: vehicles.
        leases: hold what was taken.
        each: a port for each vehicle; None: up to ten vehicles.
        port: the first one; None: of those that are free.
        start_system: system id of the first vehicle; None: the first of a row that is free.

    Raises:
        ValueError: there are not so many ids, or ports.
        ServerError: no ports, or no ids, are left.
    """
    first = start_system or _free_systems(count, leases)
    if start_system is not None:
        leases.note(map(system_name, range(first, min(first + count, NETWORK + 1))))
    if port is not None:
        found = seats(count, each=each, base=port, start_system=first)
        leases.note(_ports(found))
        return found
    for base in range(BASE_PORT, _LAST_BASE):
        found = seats(count, each=each, base=base, start_system=first)
        if leases.take(_ports(found)):
            return found
    raise ServerError(f"no ports from {BASE_PORT} on are left for {count} vehicles")


def lease_systems(wanted: Collection[int], leases: Leases) -> dict[int, int]:
    """System ids for vehicles that have ports of their own, by the id that each would have.

    They get the ids that they would have, or else a row that is free. Where there is none, or
    no folder for leases, they get their own all the same.
    """
    own = {system: system for system in wanted}
    try:
        if not wanted or leases.take(map(system_name, wanted)):
            return own
        first = _free_systems(len(wanted), leases)
    except ServerError:
        return own
    return {system: first + i for i, system in enumerate(sorted(wanted))}


def port_name(port: int) -> str:
    """What a port's lease is called."""
    return f"port-{port}"


def system_name(system: int) -> str:
    """What a system id's lease is called."""
    return f"system-{system}"


def _ports(found: Iterable[Seat]) -> list[str]:
    return [port_name(port) for port in sorted({seat.port for seat in found})]


def _free_systems(count: int, leases: Leases) -> int:
    if count > NETWORK:  # they are used again anyway
        return 1
    for first in range(1, NETWORK - count + 2):
        if leases.take(map(system_name, range(first, first + count))):
            return first
    raise ServerError(
        f"no {count} system ids in a row are left on this machine; --start-system asks for one"
    )
