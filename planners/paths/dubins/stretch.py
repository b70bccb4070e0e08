"""Car paths of a wanted length: one arc more, or a larger radius, or whole turns.

A ``Form`` is a family of flyable paths over one parameter u, for every word:

| name | u | paths |
| --- | --- | --- |
| start | phi in [0, 2 pi] | turn by phi, then the word (Chen 2023, Eqs. 18-19) |
| end | phi | the word, then turn by phi into the end pose |
| radius | R >= R_min | the word at the radius R (Eq. 25) |

all of them with ``turns`` whole turns besides. A word's length over u has jumps where an arc
wraps or the word vanishes, so that bisection alone may end at a jump: words are searched one by
one, and what is found is flown and looked at.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planners.paths.dubins.car import TURNS, WORDS, pieces_of, words
from planners.paths.dubins.pieces import F64, Piece, misses, turned

_GRID = 129  # values of u looked at first
_EXACT = 1e-10  # of the wanted length
_FULL = 2.0 * math.pi


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """Between which poses (3,), and how tight."""

    start: F64
    end: F64
    r_min: float


@dataclass(frozen=True, slots=True)
class Form:
    """A family of paths."""

    name: str  # "start", "end" or "radius"
    turn: int  # of the arc added: 1 left, -1 right; 0: as the word turns
    turns: int = 0  # whole turns besides
    largest: float = _FULL  # the largest u
    last: bool = False  # whole turns of "radius" come after the word


@dataclass(frozen=True, slots=True)
class Stretched:
    """One path of a form."""

    word: str
    length: float  # m, seen from above
    radius: float
    turns: int
    pieces: tuple[Piece, ...]


def exact(ends: Ends, form: Form, wanted: float) -> tuple[Stretched | None, bool]:
    """The path of a form that is ``wanted`` m long, with the least u; None where there is none.

    The shortest word at its u is preferred to the others; and whether it is that.
    """
    grid = np.linspace(_least(ends, form), form.largest, _GRID)
    excess = _totals(ends, form, grid) - wanted
    rising = (excess[:-1] <= 0.0) != (excess[1:] <= 0.0)
    at, word = np.nonzero(rising & (np.isfinite(excess[:-1]) | np.isfinite(excess[1:])))
    if not len(at):
        return None, False
    low = excess[at, word] <= 0.0
    below = np.where(low, grid[at], grid[at + 1])
    above = np.where(low, grid[at + 1], grid[at])
    rows = np.arange(len(at))
    for _ in range(56):
        middle = (below + above) / 2.0
        under = _totals(ends, form, middle)[rows, word] <= wanted
        below, above = np.where(under, middle, below), np.where(under, above, middle)
    found = _totals(ends, form, below)
    good = np.abs(found[rows, word] - wanted) <= _EXACT * wanted
    other = found[rows, word] > found.min(axis=-1) + _EXACT * wanted
    for row in np.lexsort((below, other)):
        path = _path(ends, form, float(below[row]), int(word[row])) if good[row] else None
        if path is not None:
            return path, not other[row]
    return None, False


def longer(ends: Ends, form: Form, wanted: float) -> Iterator[Stretched]:
    """A path of every word of a form, the shortest found that is not below ``wanted`` m."""
    grid = np.linspace(_least(ends, form), form.largest, _GRID)
    for word in range(len(WORDS)):
        values, best = grid, math.nan
        for _ in range(8):
            totals = _totals(ends, form, values)[:, word]
            totals = np.where(totals >= wanted, totals, np.inf)
            place = int(np.argmin(totals))
            if not np.isfinite(totals[place]):
                break
            best = float(values[place])
            reach = values[min(place + 1, len(values) - 1)], values[max(place - 1, 0)]
            values = np.linspace(min(*reach, best), max(*reach, best), 33)
        path = None if math.isnan(best) else _path(ends, form, best, word)
        if path is not None:
            yield path


def _least(ends: Ends, form: Form) -> float:
    return ends.r_min if form.name == "radius" else 0.0


def _parts(ends: Ends, form: Form, u: F64) -> tuple[F64, F64, F64]:
    """Pieces (m, 6, 3) of the words, the radius (m,), and what comes besides (m,) in m."""
    if form.name == "radius":
        return words(ends.start, ends.end, u), u, form.turns * _FULL * u
    start, end = ends.start, ends.end
    if form.name == "start":
        start = turned(start, form.turn, u, ends.r_min)
    else:
        end = turned(end, form.turn, -u, ends.r_min)
    radius = np.full_like(u, ends.r_min)
    return words(start, end, radius), radius, (u + form.turns * _FULL) * ends.r_min


def _totals(ends: Ends, form: Form, u: F64) -> F64:
    pieces, _, besides = _parts(ends, form, u)
    return np.asarray(pieces.sum(axis=-1) + besides[:, None])


def _path(ends: Ends, form: Form, u: float, word: int) -> Stretched | None:
    lengths, radii, besides = _parts(ends, form, np.array([u]))
    radius, added = float(radii[0]), float(besides[0])
    if not np.isfinite(lengths[0, word]).all():
        return None
    pieces = pieces_of(word, lengths[0, word])
    after = form.last or form.name == "end"
    if added > 0.0:
        extra = Piece(form.turn or TURNS[word][2 if after else 0], added)
        pieces = (*pieces, extra) if after else (extra, *pieces)
    pieces = _merged(pieces)
    if misses(ends.start, pieces, radius, ends.end):
        return None
    total = math.fsum(piece.length for piece in pieces)
    return Stretched(WORDS[word], total, radius, form.turns, pieces)


def _merged(pieces: tuple[Piece, ...]) -> tuple[Piece, ...]:
    """Neighbouring arcs of one turn as one."""
    out = [pieces[0]]
    for piece in pieces[1:]:
        if piece.turn == out[-1].turn:
            out[-1] = Piece(piece.turn, out[-1].length + piece.length)
        else:
            out.append(piece)
    return tuple(out)
