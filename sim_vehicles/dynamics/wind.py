"""Wind: a steady mean with gusts, a gust stream for each vehicle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim_vehicles.dynamics.model import F64


@dataclass(frozen=True, slots=True)
class WindSpec:
    """What the wind is like.

    Attributes:
        mean_m_s: east, north, up: where the air goes to.
        gust_m_s: standard deviation of each horizontal component.
        gust_up_m_s: standard deviation of the vertical component.
        gust_s: correlation time of the horizontal gusts.
        gust_up_s: correlation time of the vertical gusts.
    """

    mean_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gust_m_s: float = 0.0
    gust_up_m_s: float = 0.0
    gust_s: float = 5.0
    gust_up_s: float = 1.5

    def __post_init__(self) -> None:
        if not (len(self.mean_m_s) == 3 and np.all(np.isfinite(self.mean_m_s))):
            raise ValueError(f"mean_m_s must be three finite numbers: {self.mean_m_s}")
        for name in ("gust_m_s", "gust_up_m_s"):
            value = getattr(self, name)
            if not 0.0 <= value < np.inf:
                raise ValueError(f"{name} must be finite and not negative: {value}")
        for name in ("gust_s", "gust_up_s"):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise ValueError(f"{name} must be finite and positive: {value}")

    @property
    def calm(self) -> bool:
        """Whether nothing changes: no gusts."""
        return self.gust_m_s == 0.0 and self.gust_up_m_s == 0.0


class Wind:
    """Wind at each of n vehicles, as time goes on.

    Gusts are Dryden's in first order for a hovering vehicle: an
    Ornstein-Uhlenbeck process per axis, discretised exactly, so their statistics
    do not depend on the step.
    """

    def __init__(self, spec: WindSpec, n: int, rng: int | np.random.Generator) -> None:
        self._spec = spec
        self._rng = np.random.default_rng(rng)
        self._mean = np.array(spec.mean_m_s, dtype=np.float64)
        self._sigma = np.array([spec.gust_m_s, spec.gust_m_s, spec.gust_up_m_s])
        self._gust = np.zeros((n, 3))
        if not spec.calm:
            self._gust += self._rng.standard_normal((n, 3)) * self._sigma
        self._kick = np.zeros((n, 3))
        self._wind: F64 = self._mean + self._gust
        self._dt_s = 0.0
        self._retime(0.0)

    def _retime(self, dt_s: float) -> None:
        spec = self._spec
        rate = np.array([1.0 / spec.gust_s, 1.0 / spec.gust_s, 1.0 / spec.gust_up_s])
        self._keep = np.exp(-rate * dt_s)
        self._renew = self._sigma * np.sqrt(-np.expm1(-2.0 * rate * dt_s))
        self._dt_s = dt_s

    def step(self, dt_s: float) -> F64:
        """Go on by ``dt_s``; returns (n, 3) ENU m/s, used again by the next call."""
        if self._spec.calm:
            return self._wind
        if dt_s != self._dt_s:
            self._retime(dt_s)
        self._rng.standard_normal(out=self._kick)
        self._kick *= self._renew
        self._gust *= self._keep
        self._gust += self._kick
        np.add(self._gust, self._mean, out=self._wind)
        return self._wind
