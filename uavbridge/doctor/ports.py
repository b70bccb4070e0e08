"""Ports: free, or by whom they are taken."""

from __future__ import annotations

import errno
import os
import re
import socket
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Literal, TypeAlias

from uavbridge.doctor.finding import Finding, error, ok

Protocol: TypeAlias = Literal["udp", "tcp"]

_TABLES: dict[Protocol, tuple[str, ...]] = {"udp": ("udp", "udp6"), "tcp": ("tcp", "tcp6")}
_TAKEN = "taken by "
_LISTENS = "0A"  # state of a TCP socket that listens


def why_not(protocol: Protocol, host: str, port: int) -> str | None:
    """Why this process could not have the port; None: it could."""
    kind = socket.SOCK_DGRAM if protocol == "udp" else socket.SOCK_STREAM
    with closing(socket.socket(socket.AF_INET, kind)) as probe:
        if protocol == "tcp":  # as servers do, for ports that are closing
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as fault:
            if fault.errno != errno.EADDRINUSE:
                return f"can not be had on {host}: {fault.strerror or fault}"
            return f"{_TAKEN}{', '.join(holders(protocol, port)) or 'a process of another user'}"
    return None


def holders(protocol: Protocol, port: int, proc: Path = Path("/proc")) -> list[str]:
    """Processes that have the port, as "name (pid 123)"; of other users none may be seen."""
    inodes = set(_inodes(protocol, port, proc))
    if not inodes:
        return []
    found = []
    for folder in proc.glob("[0-9]*"):
        with suppress(OSError):  # it ended meanwhile, or is somebody else's
            if any(_socket(link) in inodes for link in (folder / "fd").iterdir()):
                name = (folder / "comm").read_text().strip()
                found.append(f"{name} (pid {folder.name})")
    return sorted(found)


def _inodes(protocol: Protocol, port: int, proc: Path) -> Iterator[str]:
    for table in _TABLES[protocol]:
        with suppress(OSError):
            for line in (proc / "net" / table).read_text().splitlines()[1:]:
                fields = line.split()
                local, state = int(fields[1].rpartition(":")[2], 16), fields[3]
                if local == port and (protocol == "udp" or state == _LISTENS):
                    yield fields[9]


def _socket(link: Path) -> str:
    """Inode of the socket that a file descriptor is; empty for other files."""
    match = re.fullmatch(r"socket:\[(\d+)\]", os.readlink(link))
    return match[1] if match else ""


def port_finding(protocol: Protocol, host: str, port: int, purpose: str) -> Finding:
    """Whether a port that the mission needs is to be had."""
    subject, fault = f"{protocol} port {port}", why_not(protocol, host, port)
    if fault is None:
        return ok(subject, f"free for {purpose}")
    return error(subject, fault, remedy_of(fault, f"give {purpose} another port"))


def remedy_of(fault: str, otherwise: str) -> str:
    """What to do about a port that ``why_not`` says something of."""
    taken = fault.startswith(_TAKEN)
    return f"end it, or {otherwise}" if taken else "write an address and a port of this machine"
