"""The date, for signatures alone: simulated vehicles live on simulated time."""

from __future__ import annotations

import time


def unix_us() -> int:
    """Microseconds since 1970, UTC."""
    return time.time_ns() // 1000
