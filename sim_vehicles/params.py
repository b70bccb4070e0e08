"""Parameters: one table of names for a fleet, one column of values a vehicle."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from math import inf, isfinite
from typing import TypeAlias

import numpy as np

from sim_vehicles.dynamics.model import F64


class Type(IntEnum):
    """How a value is kept; numbers as in MAV_PARAM_TYPE."""

    INT8 = 2
    INT16 = 4
    INT32 = 6
    REAL32 = 9


Derive: TypeAlias = Callable[[Callable[[str], float]], Mapping[str, float]]
"""Hidden parameters of one vehicle, by the values of those that clients see."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter: its value is always within ``low`` and ``high``."""

    name: str
    type: Type
    default: float
    low: float = -inf
    high: float = inf


class Parameters:
    """Values of all parameters of n vehicles.

    Args:
        table: the parameters, in the order in which they are listed.
        n: number of vehicles.
        overrides: values other than the defaults, for all vehicles.
        hidden: parameters that the autopilot goes by and clients do not see.
        derive: gives values of hidden ones.

    Raises:
        ValueError: an override of an unknown parameter, or out of range.
    """

    def __init__(
        self,
        table: Sequence[Parameter],
        n: int,
        overrides: Mapping[str, float] | None = None,
        *,
        hidden: Sequence[Parameter] = (),
        derive: Derive | None = None,
    ) -> None:
        self.table = tuple(sorted(table, key=lambda parameter: parameter.name))
        seen = {parameter.name for parameter in self.table}
        self._all = self.table + tuple(each for each in hidden if each.name not in seen)
        self._row = {parameter.name: row for row, parameter in enumerate(self._all)}
        defaults = np.array([_single(parameter.default) for parameter in self._all])
        self._values = np.repeat(defaults[:, np.newaxis], n, axis=1)
        self.version = 0  # grows with every change
        self._derive = derive
        for vehicle in range(n):
            self._follow(vehicle)
        for name, value in (overrides or {}).items():
            if name not in self._row:
                raise ValueError(f"the autopilot has no parameter {name}")
            self._set_all(name, value)

    def __len__(self) -> int:
        return len(self.table)

    def __contains__(self, name: str) -> bool:
        return name in self._row

    def row(self, name: str) -> int | None:
        """Place of a parameter in the table; None: there is none of that name."""
        row = self._row.get(name)
        return row if row is not None and row < len(self.table) else None

    def column(self, name: str) -> F64:
        """Values (n,) of one parameter, live: they change as parameters are set."""
        column: F64 = self._values[self._row[name]]
        return column

    def get(self, vehicle: int, name: str) -> float:
        """The value of one parameter of one vehicle."""
        return float(self._values[self._row[name], vehicle])

    def override(self, values: Mapping[str, float]) -> None:
        """Change values of all vehicles; names that are not known are passed over.

        Raises:
            ValueError: out of range.
        """
        for name, value in values.items():
            if name in self._row:
                self._set_all(name, value)

    def _set_all(self, name: str, value: float) -> None:
        for vehicle in range(self._values.shape[1]):
            self.set(vehicle, name, value)

    def set(self, vehicle: int, name: str, value: float) -> None:
        """Change one value of one vehicle.

        Raises:
            ValueError: not finite, out of range, or a fraction for a whole number.
        """
        row = self._row[name]
        parameter = self._all[row]
        if not isfinite(value) or not parameter.low <= value <= parameter.high:
            raise ValueError(
                f"parameter {name} must be {parameter.low:g}..{parameter.high:g}, not {value:g}"
            )
        if parameter.type is not Type.REAL32 and value != int(value):
            raise ValueError(f"parameter {name} is a whole number, not {value:g}")
        self._values[row, vehicle] = _single(value)
        self._follow(vehicle)
        self.version += 1

    def _follow(self, vehicle: int) -> None:
        if self._derive is not None:
            for name, value in self._derive(lambda known: self.get(vehicle, known)).items():
                self._values[self._row[name], vehicle] = value


def _single(value: float) -> float:
    """As a vehicle keeps it: whole numbers are exact, others have single precision."""
    return value if value == int(value) else float(np.float32(value))
