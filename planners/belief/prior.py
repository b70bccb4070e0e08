"""Belief maps before the search, from mixed Gaussians.

Liu et al. 2022, "Emergent search of UAV swarm guided by the target probability
map", Eqs. (1) and (2).

    f(x, y) = 1 / (2 pi s1 s2 sqrt(1 - rho^2)) exp(-1 / (2 (1 - rho^2))
              {(x - mu1)^2/s1^2 - 2 rho (x - mu1)(y - mu2)/(s1 s2) + (y - mu2)^2/s2^2})   (1)
    f(x, y) = sum_i alpha_i f_i(x, y)                                                     (2)

| symbol | name |
| --- | --- |
| mu1, mu2 | ``means`` |
| sigma_1 = sigma_2 = sigma_0 | ``sigma_m`` |
| rho | 0: "independent in the x and y directions" |
| alpha_i | ``weights`` |
| P_mn | the value of ``gaussian_prior`` |

DEVIATION: the last term of Eq. (1) is printed with a minus, with which f would
not be a density. rho is called a covariance; it is a correlation.

DEVIATION: the paper's P_mn, the integral of "s f" over the cell, has an area
twice, and a density integrates to about 1 a target, which is no probability of
a cell. Here the cells' shares of f are scaled so that the likeliest has
``peak``, upon a ``floor``: with 0 in a cell, Eq. (4) could never find a target there.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from planners.grid import Grid
from planners.types import F64


def density(points: npt.ArrayLike, mean: npt.ArrayLike, sigma_m: float) -> F64:
    """Density (...) in 1/m^2 of a target's place at points (..., 2), Eq. (1) with rho = 0."""
    offset = (np.asarray(points, dtype=np.float64) - np.asarray(mean)) / sigma_m
    square = (offset * offset).sum(axis=-1)
    return np.asarray(np.exp(-square / 2.0) / (2.0 * math.pi * sigma_m**2))


def mixture(
    points: npt.ArrayLike, means: npt.ArrayLike, weights: npt.ArrayLike, sigma_m: float
) -> F64:
    """Density (...) of all targets at points (..., 2), Eq. (2).

    Args:
        points: (..., 2) m.
        means: (k, 2) m.
        weights: (k,) the targets' importance, alpha.
        sigma_m: sigma_0.
    """
    at = np.asarray(points, dtype=np.float64)[..., None, :]
    return np.asarray((density(at, means, sigma_m) * np.asarray(weights)).sum(axis=-1))


def cell_shares(grid: Grid, means: npt.ArrayLike, weights: npt.ArrayLike, sigma_m: float) -> F64:
    """Integral (columns, rows) of Eq. (2) over each cell; arguments as of ``mixture``."""
    total = np.zeros(grid.shape)
    west = grid.west_m + grid.cell_m * np.arange(grid.columns + 1)
    south = grid.south_m + grid.cell_m * np.arange(grid.rows + 1)
    for (x, y), weight in zip(
        np.asarray(means, dtype=np.float64), np.asarray(weights, dtype=np.float64), strict=True
    ):
        across = np.diff(_below(west, float(x), sigma_m))
        along = np.diff(_below(south, float(y), sigma_m))
        total += weight * across[:, None] * along
    return total


def gaussian_prior(
    grid: Grid,
    means: npt.ArrayLike,
    sigma_m: float,
    *,
    floor: float,
    peak: float,
    weights: npt.ArrayLike | None = None,
) -> F64:
    """Prior map (columns, rows) with a bump at each expected target.

    Args:
        grid: the search area.
        means: (k, 2) m, where targets are expected; none leaves the floor.
        sigma_m: sigma_0.
        floor: probability of a cell where nothing is expected.
        peak: probability of the likeliest cell.
        weights: (k,) alpha; None: all alike.

    Raises:
        ValueError: not 0 < floor <= peak < 1, or sigma_m is not positive.
    """
    if not 0.0 < floor <= peak < 1.0:
        raise ValueError(f"a prior needs 0 < floor <= peak < 1, not {floor} and {peak}")
    if not sigma_m > 0.0:
        raise ValueError(f"sigma_m must be positive, not {sigma_m}")
    points = np.asarray(means, dtype=np.float64).reshape(-1, 2)
    shares = cell_shares(
        grid, points, np.ones(len(points)) if weights is None else weights, sigma_m
    )
    most = float(shares.max())
    return np.asarray(floor + (peak - floor) * shares / (most if most > 0.0 else 1.0))


def _below(edges: npt.ArrayLike, mean: float, sigma_m: float) -> F64:
    """Share of a Gaussian below each edge."""
    return np.array(
        [0.5 * math.erf((edge - mean) / (sigma_m * math.sqrt(2.0))) for edge in np.asarray(edges)]
    )
