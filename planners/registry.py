"""The planners that come with the package, and how a mission binds one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, fields
from typing import Any, TypeVar

from planners.planner import Planner, PlannerKind
from planners.search.boids import BOIDS, BOIDS_GUIDED
from planners.search.esustpm import ESUSTPM
from planners.search.mountain.planner import MOUNTAIN
from planners.search.mower import MOWER
from planners.search.pheromone.detection import PHEROMONE
from planners.search.pheromone.scenario import PHEROMONE_SCENARIO
from planners.search.random_walk import RANDOM
from planners.search.starling import STARLING
from planners.search.sweep import SWEEP
from planners.types import Scenario

P = TypeVar("P")

BUILTIN: Mapping[str, PlannerKind] = {
    kind.name: kind
    for kind in (
        ESUSTPM,
        BOIDS_GUIDED,
        BOIDS,
        MOWER,
        SWEEP,
        RANDOM,
        STARLING,
        MOUNTAIN,
        PHEROMONE,
        PHEROMONE_SCENARIO,
    )
}


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a planner, for people and for schemas."""

    name: str
    kind: type[Any]  # bool, int, float or str
    default: Any
    unit: str
    doc: str
    low: float | None
    high: float | None
    choices: tuple[str, ...]

    @property
    def allowed(self) -> str:
        """The values allowed, in words; empty when any will do."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        if self.low is not None and self.high is not None:
            return f"{self.low:g} to {self.high:g}"
        if self.low is not None:
            return f"at least {self.low:g}"
        return "" if self.high is None else f"at most {self.high:g}"


def describe(kind: PlannerKind) -> tuple[Parameter, ...]:
    """Parameters of a planner, in the order of its dataclass."""
    return described(kind.params)


def described(params: type[Any]) -> tuple[Parameter, ...]:
    """Parameters of a dataclass whose fields are made with ``planners.planner.param``."""
    return tuple(_parameter(part) for part in fields(params))


def bind(kind: PlannerKind, scenario: Scenario, values: Mapping[str, Any]) -> Planner:
    """A planner for one mission.

    Args:
        kind: which.
        scenario: what every agent knows before take-off.
        values: parameters by name; those not named have their defaults.

    Raises:
        ValueError: a parameter is not known, of the wrong type or out of range;
            names the planner and the parameter.
    """
    return kind.bind(scenario, parameters(kind, values))


def parameters(kind: PlannerKind, values: Mapping[str, Any]) -> Any:
    """The planner's parameter dataclass from a mapping. Raises as ``bind``."""
    return filled(f"planner {kind.name}", kind.params, values)


def filled(owner: str, params: type[P], values: Mapping[str, Any]) -> P:
    """A parameter dataclass from a mapping; ``owner`` begins the messages. Raises as ``bind``."""
    known = {part.name: part for part in described(params)}
    for name in values:
        if name not in known:
            listed = ", ".join(known) or "none"
            raise ValueError(f"{owner}: unknown parameter {name!r} (known: {listed})")
    checked = {name: _checked(owner, known[name], value) for name, value in values.items()}
    try:
        return params(**checked)
    except ValueError as error:
        raise ValueError(f"{owner}: {error}") from error


def _parameter(part: Field[Any]) -> Parameter:
    default = part.default
    if default is MISSING:
        raise ValueError(f"parameter {part.name} has no default")
    meta = part.metadata
    return Parameter(
        part.name,
        type(default),
        default,
        meta.get("unit", ""),
        meta.get("doc", ""),
        meta.get("low"),
        meta.get("high"),
        tuple(meta.get("choices", ())),
    )


def _checked(owner: str, parameter: Parameter, value: Any) -> Any:
    where = f"{owner}: parameter {parameter.name}"
    if parameter.kind is float and type(value) is int and abs(value) < _EXACT:
        value = float(value)
    if type(value) is not parameter.kind:
        raise ValueError(
            f"{where} must be {_article(parameter.kind)}, not {_article(type(value))} ({value!r})"
        )
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{where} must be finite, not {value}")
    if not _in_range(parameter, value):
        raise ValueError(f"{where} must be {parameter.allowed}, not {value!r}")
    return value


def _in_range(parameter: Parameter, value: Any) -> bool:
    if parameter.choices:
        return value in parameter.choices
    low_holds = parameter.low is None or value >= parameter.low
    return low_holds and (parameter.high is None or value <= parameter.high)


_EXACT = 2**53  # integers below it are floats without loss
_WORDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}


def _article(kind: type[Any]) -> str:
    return _WORDS.get(kind, f"a {kind.__name__}")
