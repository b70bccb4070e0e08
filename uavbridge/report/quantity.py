"""Numbers as people read them."""

from __future__ import annotations

import math


def duration(seconds: float) -> str:
    """Minutes and seconds, ``4:07``; hours where there are any, ``1:02:03``."""
    if not math.isfinite(seconds):
        return "-"
    minutes, second = divmod(round(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}" if hours else f"{minute}:{second:02}"


def data_size(size: float) -> str:
    """Bytes in the unit that leaves one to three digits before the point (1 kB = 1000 B)."""
    for unit in ("B", "kB", "MB"):
        if abs(size) < 999.5:
            return f"{size:.0f} {unit}" if unit == "B" or size >= 100 else f"{size:.1f} {unit}"
        size /= 1000
    return f"{size:.1f} GB"


def count(value: int) -> str:
    """A whole number in groups of three."""
    return f"{value:,}"


def number(value: float, unit: str) -> str:
    """Three digits or so, with the unit; ``-`` for what is not known."""
    if not math.isfinite(value):
        return "-"
    digits = 0 if abs(value) >= 99.95 else 1 if abs(value) >= 9.995 else 2
    return f"{value:.{digits}f} {unit}".rstrip()


def plain(text: str) -> str:
    """One line without control characters, safe to show on a terminal."""
    return "".join(c if c.isprintable() else " " for c in text)
