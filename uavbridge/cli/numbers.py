"""Options that are numbers one can reckon with."""

from __future__ import annotations

from math import isfinite
from typing import Any

import click


class Finite(click.FloatRange):
    """A number of the range that is neither infinite nor none at all."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"{value} is not a finite number", param, ctx)
        return number


ABOVE_ZERO = Finite(min=0.0, min_open=True)
NOT_NEGATIVE = Finite(min=0.0)
