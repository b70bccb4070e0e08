"""Beyond Zhou 2023: robots that stand still and fall silent when their energy is spent."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uavbridge.experiments.experiment import Case, Experiment, Outcome
from uavbridge.experiments.zhou import setting
from uavbridge.experiments.zhou.setting import ZhouParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLE = 4
LIMITS_M = (500.0, 1000.0, 1500.0, 2000.0, 2500.0, 3000.0, 4000.0)


def cases(params: ZhouParams) -> list[Case]:
    """A case an n_u and limit, on the terrain of Table 4."""
    return [
        {"table": TABLE, "n_u": n_u, "energy_limit_m": limit}
        for n_u in params.numbers
        for limit in LIMITS_M
    ]


def plot(figure: Figure, outcome: Outcome) -> None:
    """Targets found over the limit."""
    from uavbridge.experiments.zhou import plots

    plots.sweeps(figure, outcome, {"energy_limit_m": "distance each robot may drive (m)"}, "found")


EXPERIMENT = Experiment(
    name="zhou-energy",
    summary="targets found before the robots' energy is spent",
    source="beyond Zhou 2023, Table 4",
    params=ZhouParams,
    cases=cases,
    simulate=setting.measure,
    file=__file__,
    runs=30,
    block=setting.BLOCK,
    paired=("energy_limit_m",),
    plot=plot,
)
