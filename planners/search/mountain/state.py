"""What a robot of the mountain search keeps, senses and hears, as arrays.

Leading axes (...) are those of the deciding robots: none for one robot, or runs and
robots. Messages have one more axis (k), the senders; the robot's own last message is
among them. Targets (T) are numbered as the caller likes, -1 is none.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from planners.types import F64, I64, Bools

Array = npt.NDArray[Any]


@dataclass(frozen=True, slots=True, eq=False)
class Messages:
    """What robots tell in one step; rides on their frames."""

    task: I64  # (..., k) target answered to or worked for
    first: Bools  # (..., k) class I: hears it itself
    free: Bools  # (..., k) may be recruited
    leads: Bools  # (..., k) its roster holds
    strength: F64  # (..., k) I, of class I
    best: F64  # (..., k) strongest I of its own since it joined; -inf: none
    best_place: F64  # (..., k, 3) where
    roster: I64  # (..., k, N_m) ids of the members of the suballiance it leads
    found: Bools  # (..., k, T) targets known to be found

    def map(self, change: Callable[[Array], Array]) -> Messages:
        """The messages with every array changed."""
        changed: dict[str, Any] = {
            part.name: change(getattr(self, part.name)) for part in fields(self)
        }
        return Messages(**changed)


@dataclass(frozen=True, slots=True, eq=False)
class Robots:
    """A robot's memory."""

    velocity: F64  # (..., 3) m a step, as decided last
    member: Bools  # (...) works in a suballiance
    waited: I64  # (...) steps since it has told its task as class I
    rest: I64  # (...) steps that it roams before it answers to a target again
    shared: F64  # (...) strongest I of the suballiance since it joined; -inf: none
    shared_place: F64  # (..., 3) where, g*
    told: Messages  # (...) its last message, without the axis k

    def map(self, change: Callable[[Array], Array]) -> Robots:
        """The memory with every array changed."""
        names = [part.name for part in fields(self) if part.name != "told"]
        changed: dict[str, Any] = {name: change(getattr(self, name)) for name in names}
        return Robots(**changed, told=self.told.map(change))


@dataclass(frozen=True, slots=True, eq=False)
class Sensed:
    """What a robot's own sensors say."""

    position: F64  # (..., 3) m
    strength: F64  # (..., T) I
    heard: Bools  # (..., T) within d_tar
    arrived: Bools  # (..., T) within d_0


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """What a robot knows of others, and of itself by its last message."""

    ids: I64  # (..., k)
    position: F64  # (..., k, 3) m
    known: Bools  # (..., k) which rows count: heard lately, or the robot itself
    messages: Messages  # (..., k)


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Random numbers of one step, uniform in [0, 1)."""

    target: F64  # (...) r_a of Eq. (6)
    own: F64  # (..., 3) r_1; the first alone where it is a scalar
    shared: F64  # (..., 3) r_2
    heading: F64  # (...) for a robot that has none

    @staticmethod
    def of(numbers: F64) -> Draws:
        """From (..., 8) numbers."""
        return Draws(numbers[..., 0], numbers[..., 1:4], numbers[..., 4:7], numbers[..., 7])


DRAWS = 8


def length(vectors: F64) -> F64:
    """Lengths (...) of vectors (..., 3); much faster than a sum over a short axis."""
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def fresh(lead: tuple[int, ...], targets: int, members: int, velocity: F64) -> Robots:
    """Memory before the first step, velocities (..., 3) in m a step."""
    nobody = np.full(lead, -1, dtype=np.int64)
    no, yes = np.zeros(lead, np.bool_), np.ones(lead, np.bool_)
    least, place = np.full(lead, -np.inf), np.zeros((*lead, 3))
    roster = np.full((*lead, members), -1, dtype=np.int64)
    found = np.zeros((*lead, targets), np.bool_)
    zero = np.zeros(lead)
    told = Messages(nobody, no, yes, no, zero, least, place, roster, found)
    count = np.zeros(lead, dtype=np.int64)
    return Robots(velocity, no, count, count, least, place, told)
