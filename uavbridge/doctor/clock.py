"""The clock of this machine: whether somebody keeps it right."""

from __future__ import annotations

import ctypes
from typing import Final

from uavbridge.doctor.finding import Finding, ok, warning

_UNSYNCHRONISED: Final = 0x40  # STA_UNSYNC of Linux' adjtimex(2)
_MOST_OFF_US: Final = 100_000


class _Timex(ctypes.Structure):
    """``struct timex`` up to what is read of it."""

    _fields_ = (
        ("modes", ctypes.c_uint),
        ("offset", ctypes.c_long),
        ("frequency", ctypes.c_long),
        ("most_off_us", ctypes.c_long),
        ("about_off_us", ctypes.c_long),
        ("status", ctypes.c_int),
        ("more", ctypes.c_byte * 256),
    )


def clock_finding() -> Finding:
    """What the kernel knows of how right the date is; for missions of several machines."""
    read, known = _Timex(), getattr(ctypes.CDLL(None), "adjtimex", None)
    if known is None or known(ctypes.byref(read)) < 0:
        return warning("clock", "nobody here knows whether this machine's date is right")
    return of_kernel(read.status, read.most_off_us)


def of_kernel(status: int, most_off_us: int) -> Finding:
    """The same of the two values of adjtimex(2)."""
    if status & _UNSYNCHRONISED:
        text = "this machine's clock is not kept by NTP or the like"
        return warning("clock", text, "start chronyd or systemd-timesyncd on every machine")
    text = f"this machine's date is at most {most_off_us / 1e3:.0f} ms off"
    if most_off_us > _MOST_OFF_US:
        return warning("clock", text, "wait until its time service has settled")
    return ok("clock", text)
