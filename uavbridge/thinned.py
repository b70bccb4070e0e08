"""Lists of a long flight that do not grow for ever."""

from __future__ import annotations

from typing import Final, TypeVar

T = TypeVar("T")

MOST: Final = 7200  # two hours at one a second


def keep(items: list[T], item: T, most: int = MOST) -> None:
    """Append; a full list first gives up every other item: what is older is sparser then."""
    if len(items) >= most:
        items[:] = items[::2]
    items.append(item)
