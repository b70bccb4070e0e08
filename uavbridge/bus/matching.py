"""Key expressions as zenoh has them, for the bus that does without zenoh.

``*`` is one whole chunk, ``$*`` any characters within a chunk, ``**`` any number
of chunks, none too. Chunks that begin with ``@`` are matched by none of them.
"""

from __future__ import annotations

import re
from functools import lru_cache

_STARS = re.compile(r"\*")


def check(expression: str) -> str:
    """The expression itself, when it is a well-formed, canonical one.

    Raises:
        ValueError: it is not; the message says why.
    """
    fault = _fault(expression)
    if fault:
        raise ValueError(f"key {expression!r}: {fault}")
    return expression


def is_concrete(expression: str) -> bool:
    """Whether the expression names exactly one key."""
    return "*" not in expression


@lru_cache(maxsize=4096)
def intersects(one: str, other: str) -> bool:
    """Whether some key matches both expressions (either may be a plain key)."""
    return _chunks_meet(one.split("/"), other.split("/"))


def _fault(expression: str) -> str:
    chunks = expression.split("/")
    if "" in chunks:
        return "an empty chunk, or a slash at an end"
    if "#" in expression or "?" in expression:
        return "'#' and '?' are not allowed"
    for chunk, following in zip(chunks, [*chunks[1:], ""], strict=True):
        if chunk == "**" and following in ("*", "**"):
            return f"write '*/**' for '**/{following}'" if following == "*" else "'**' twice"
        if chunk in ("*", "**"):
            continue
        if "$*$*" in chunk or chunk == "$*":
            return "write '*' for a whole chunk"
        plain = chunk.replace("$*", "")
        if "*" in plain or "$" in plain:
            return "'*' stands alone or as '$*'"
    return ""


def _chunks_meet(one: list[str], other: list[str]) -> bool:
    if not one or not other:
        return all(chunk == "**" for chunk in one or other)
    if one[0] == "**":
        return _skip_meets(one, other)
    if other[0] == "**":
        return _skip_meets(other, one)
    return _chunk_meets(one[0], other[0]) and _chunks_meet(one[1:], other[1:])


def _skip_meets(wild: list[str], other: list[str]) -> bool:
    """``wild`` begins with ``**``: it takes nothing, or one more chunk of the other."""
    if _chunks_meet(wild[1:], other):
        return True
    return not other[0].startswith("@") and _chunks_meet(wild, other[1:])


def _chunk_meets(one: str, other: str) -> bool:
    if one == other:
        return True
    if one.startswith("@") or other.startswith("@"):
        return False
    if one == "*" or other == "*":
        return True
    if "$*" not in one and "$*" not in other:
        return False
    return _globs_meet(one.replace("$*", "*"), other.replace("$*", "*"))


def _globs_meet(one: str, other: str) -> bool:
    """Whether some text matches both, ``*`` standing for any characters."""
    reached = {(0, 0)}
    frontier = [(0, 0)]
    while frontier:
        i, j = frontier.pop()
        for step in _glob_steps(one[i : i + 1], other[j : j + 1], i, j):
            if step not in reached:
                reached.add(step)
                frontier.append(step)
    return (len(one), len(other)) in reached


def _glob_steps(a: str, b: str, i: int, j: int) -> list[tuple[int, int]]:
    steps = []
    if a == "*":
        steps.append((i + 1, j))
    if b == "*":
        steps.append((i, j + 1))
    if a == "*" and b:
        steps.append((i, j + 1))
    if b == "*" and a:
        steps.append((i + 1, j))
    if a and a == b:
        steps.append((i + 1, j + 1))
    return steps
