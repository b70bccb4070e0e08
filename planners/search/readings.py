"""Parameters that several planners share word for word: the readings of guidance, edges, noise.

Each function makes the field of a parameter dataclass, with the planner's own default.
"""

from __future__ import annotations

from typing import Any

from planners.planner import param


def keep(default: str) -> Any:
    """How long a guide cell draws."""
    return param(
        default,
        unit="-",
        doc="a guide cell is kept until entered, or only while no surrounding cell is better",
        choices=("entered", "best"),
    )


def escape_ratio(default: float) -> Any:
    """When an agent leaves cells that are searched."""
    return param(
        default,
        unit="1",
        doc="leave when the best surrounding cell is below this share of the map's best; 0: never",
        low=0.0,
        high=1.0,
    )


def ties() -> Any:
    """Which of equally likely cells draws."""
    return param(
        "nearest",
        unit="-",
        doc="of equally likely surrounding cells the nearest draws, or the lowest number",
        choices=("nearest", "lowest"),
    )


def guide_point() -> Any:
    """The point of a guide cell."""
    return param(
        "centre",
        unit="-",
        doc="a guide cell draws to its centre, or to its south-western corner",
        choices=("centre", "corner"),
    )


def boundary() -> Any:
    """What happens at the edge."""
    return param(
        "vector",
        unit="-",
        doc="at the boundary reverse the whole velocity, or the component that crosses",
        choices=("vector", "component"),
    )


def margin_m() -> Any:
    """Where the edge is."""
    return param(15.0, unit="m", doc="the boundary lies this far inside the area's edges", low=0.0)


def heading_noise_rad() -> Any:
    """The source of randomness."""
    return param(0.1, unit="rad", doc="standard deviation of the noise on the heading", low=0.0)


def forget_s() -> Any:
    """How long neighbours are remembered."""
    return param(5.0, unit="s", doc="neighbours not heard for longer are gone", low=0.0)
