"""The planner seam: ``(view, memory, rng) -> (goal, memory)``.

A planner is a pure function. What it must remember is a frozen value that
survives a round trip through bytes (``planners.memory``); the generator it is
given is derived from (seed, agent, tick), so that no history hides in it.

A ``PlannerKind`` is what a registry holds: a name, the parameters, and how to
bind them to a scenario. Third parties publish one under the entry-point group
``uavbridge.planners``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, dataclass, field, fields
from typing import Any, Protocol

from numpy.random import Generator

from planners.types import Goal, Scenario, View


class Planner(Protocol):
    """One bound planner: the same object may serve every agent of a mission."""

    def init(self, view: View, /) -> Any:
        """Memory before the first decision: a frozen dataclass, or None."""
        ...

    def plan(self, view: View, memory: Any, rng: Generator, /) -> tuple[Goal, Any]:
        """One decision. Changes none of its arguments."""
        ...


@dataclass(frozen=True, slots=True)
class PlannerKind:
    """A planner as a registry lists it."""

    name: str
    summary: str  # one line, with the source
    params: type[Any]  # frozen dataclass, each field made with ``param``
    bind: Callable[[Scenario, Any], Planner]

    def parameters(self) -> tuple[Field[Any], ...]:
        """The parameters' dataclass fields, with ``unit`` and ``doc`` in their metadata."""
        return fields(self.params)


def param(
    default: Any,
    *,
    unit: str,
    doc: str,
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """A documented field of a parameter dataclass.

    Args:
        default: used when the mission file is silent; its type is the parameter's type.
        unit: such as ``"m"``, ``"m/s"`` or ``"1"`` for a bare number.
        doc: one line.
        low: least value allowed, itself included.
        high: greatest value allowed, itself included.
        choices: the words allowed, for a parameter that is a str.
    """
    metadata = {"unit": unit, "doc": doc, "low": low, "high": high, "choices": choices}
    return field(default=default, metadata=metadata)
