r"""Dubins' airplane: a car with a height and a largest climb angle.

Chitsaz and LaValle 2007; Owen, Beard and McLain 2015; Chen 2023, section 4.1, Eqs. (13)-(26) as
reconstructed in docs/planners/starling.md. With L the length of the shortest car path at R_min,
gamma_max the largest climb angle and H = |dz| / tan(gamma_max) the length seen from above that
the climb needs:

| case | when | path |
| --- | --- | --- |
| low | H <= L | the car's path, climbing at gamma = atan(dz / L) |
| medium | L < H <= L + 2 pi R_min | an arc more, after the start (climb) or before the end |
| high | beyond | k = floor((H - L) / 2 pi R_min) helix turns, there too, at a radius R >= R_min |

Medium and high paths climb at gamma_max and are H long, which is the least possible, so that any
form that has this length will do. Where the paper's form has none (start and end closer than
about 4 R_min), the arc is tried with the other turn and at the other end, then a larger radius,
then all of them with a helix turn less; if no form has this length, the shortest longer path
found is flown at a smaller climb angle. Every path is flown forwards before it is returned.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planners.paths.dubins.car import TURNS, WORDS, CarPath, car_lengths, distances, positive
from planners.paths.dubins.car import shortest_car as _shortest_car
from planners.paths.dubins.pieces import F64, Piece, along
from planners.paths.dubins.stretch import Ends, Form, Stretched, exact, longer

_FULL = 2.0 * math.pi


@dataclass(frozen=True, slots=True)
class AirplanePath:
    """A path of an airplane.

    Attributes:
        case: "low", "medium" or "high".
        word: of the car's part, such as "LSR".
        length: m, in space.
        gamma: climb angle, rad, positive upwards.
        radius: m.
        turns: whole helix turns.
        start: x, y, z, psi.
        height: m climbed.
        pieces: from start to end, their lengths seen from above.
    """

    case: str
    word: str
    length: float
    gamma: float
    radius: float
    turns: int
    start: tuple[float, float, float, float]
    height: float
    pieces: tuple[Piece, ...]

    def points(self, step: float) -> F64:
        """Poses (n, 4) x, y, z, psi from start to end, no more than ``step`` m apart in space.

        psi is continuous: at the end it may differ from the end's by whole turns.
        """
        share = distances(self.length, step) / self.length if self.length else np.zeros(2)
        x, y, z, psi = self.start
        level = math.fsum(piece.length for piece in self.pieces)
        seen = along((x, y, psi), self.pieces, self.radius, share * level)
        return np.column_stack((seen[:, :2], z + share * self.height, seen[:, 2]))


def airplane(
    start: Sequence[float] | F64, end: Sequence[float] | F64, r_min: float, gamma_max: float
) -> AirplanePath:
    """The shortest path between two poses x, y, z, psi.

    Args:
        start: x, y, z in m, z up, psi in rad.
        end: the same.
        r_min: least turning radius, m.
        gamma_max: largest climb and descent angle, rad, below pi/2.

    Raises:
        ValueError: a pose is not four finite numbers, or a limit makes no sense.
    """
    first, last = _pose(start), _pose(end)
    positive(r_min, "r_min")
    if not 0.0 < gamma_max < math.pi / 2.0:
        raise ValueError(f"gamma_max must lie between 0 and pi/2, not {gamma_max}")
    height = last[2] - first[2]
    car = _shortest_car((*first[:2], first[3]), (*last[:2], last[3]), r_min)
    wanted = abs(height) / math.tan(gamma_max)
    if wanted <= car.length * (1.0 + 1e-12):
        level = Stretched(car.word, car.length, car.radius, 0, car.pieces)
        return _climbing("low", level, first, height)
    ends = Ends(np.array((*first[:2], first[3])), np.array((*last[:2], last[3])), float(r_min))
    turns = math.floor((wanted - car.length) / (_FULL * r_min))  # Eq. (24)
    high = wanted > car.length + _FULL * r_min
    turns = max(turns, 1) if high else 0
    found = _stretched(ends, car, wanted, turns, rising=height > 0.0)
    return _climbing("high" if high else "medium", found, first, height)


def airplane_lengths(start: F64, end: F64, r_min: float, gamma_max: float) -> F64:
    """Lengths (...) m of the shortest paths between poses (..., 4).

    Without a search: exact but where no path is as short as the climb allows, there too small.
    """
    level = car_lengths(start[..., (0, 1, 3)], end[..., (0, 1, 3)], r_min)
    height = np.abs(end[..., 2] - start[..., 2])
    return np.asarray(np.maximum(np.hypot(level, height), height / math.sin(gamma_max)))


def _stretched(ends: Ends, car: CarPath, wanted: float, turns: int, *, rising: bool) -> Stretched:
    """A path ``wanted`` m long seen from above, or the shortest longer one."""
    forms: list[Form] = []
    for whole in range(turns, max(turns - 2, -1), -1):
        tier = list(_forms(ends, car, wanted, whole, rising=rising))
        forms += tier
        second: Stretched | None = None
        for form in tier:
            path, shortest = exact(ends, form, wanted)
            if path is not None and shortest:  # an arc, then a car's shortest path, as printed
                return path
            second = second or path
        if second is not None:
            return second
    more = Form("radius", 0, turns + 1, ends.r_min, last=not rising)
    found = [path for form in (*forms, more) for path in longer(ends, form, wanted)]
    if not found:
        raise ValueError(f"no path climbs from {ends.start} to {ends.end}")
    return min(found, key=lambda path: path.length)


def _forms(ends: Ends, car: CarPath, wanted: float, turns: int, *, rising: bool) -> Iterator[Form]:
    """The paper's form first."""
    apart = float(np.hypot(*(ends.end - ends.start)[:2]))
    largest = wanted / (_FULL * turns) if turns else (wanted + apart) / 2.0
    wider = Form("radius", 0, turns, max(largest, ends.r_min), last=not rising)
    letters = TURNS[WORDS.index(car.word)]
    first, second = ("start", "end") if rising else ("end", "start")
    near = {"start": letters[0], "end": letters[2]}
    arcs = [Form(side, sign * near[side], turns) for side in (first, second) for sign in (1, -1)]
    yield from (wider, *arcs) if turns else (*arcs, wider)


def _climbing(
    case: str, level: Stretched, start: tuple[float, float, float, float], height: float
) -> AirplanePath:
    gamma = math.atan2(height, level.length) if height else 0.0  # Eq. (16)
    return AirplanePath(
        case,
        level.word,
        math.hypot(level.length, height),  # Eqs. (17), (21), (26)
        gamma,
        level.radius,
        level.turns,
        start,
        height,
        level.pieces,
    )


def _pose(pose: Sequence[float] | F64) -> tuple[float, float, float, float]:
    values = tuple(float(value) for value in pose)
    if len(values) != 4 or not all(math.isfinite(value) for value in values):
        raise ValueError(f"a pose is x, y, z, psi, four finite numbers, not {pose}")
    return values[0], values[1], values[2], values[3]
