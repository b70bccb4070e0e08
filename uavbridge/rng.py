"""Random streams spawned by name from a mission's one seed."""

from __future__ import annotations

import hashlib

import numpy as np


def stream(seed: int, *names: str | int) -> np.random.Generator:
    """A generator that depends on the seed and the names alone.

    ``stream(7, "planner", agent, tick)`` is the same whatever was drawn before,
    in whichever process, with any PYTHONHASHSEED.
    """
    key = hashlib.sha256(repr((int(seed), *names)).encode()).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(key[:16], "little")))
