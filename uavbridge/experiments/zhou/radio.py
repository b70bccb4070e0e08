"""Beyond Zhou 2023: communication range, packet loss and delay, open by its conclusion."""

from __future__ import annotations

from typing import TYPE_CHECKING

from uavbridge.experiments.experiment import Case, Experiment, Outcome
from uavbridge.experiments.zhou import setting
from uavbridge.experiments.zhou.setting import ZhouParams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

N_U, TABLE = 40, 4
RANGES = (0.0, 50.0, 100.0, 200.0, 300.0, 500.0, 1500.0)
LOSSES = (0.1, 0.3, 0.5, 0.8)
DELAYS = (1, 2, 5, 10, 20)


def cases(params: ZhouParams) -> list[Case]:
    """Each of the three by itself, on the terrain of Table 4."""
    base = {"table": TABLE, "n_u": N_U}
    sweeps: list[Case] = [{**base, "radio_m": radio} for radio in RANGES]
    sweeps += [{**base, "loss": loss} for loss in LOSSES]
    return [*sweeps, *({**base, "delay": delay} for delay in DELAYS)]


def plot(figure: Figure, outcome: Outcome) -> None:
    """Steps over each of the three."""
    from uavbridge.experiments.zhou import plots

    plots.sweeps(
        figure,
        outcome,
        {
            "radio_m": "communication range (m)",
            "loss": "share of messages lost",
            "delay": "delay (steps)",
        },
        "steps",
    )


EXPERIMENT = Experiment(
    name="zhou-radio",
    summary="steps and energy over communication range, loss and delay, 40 robots",
    source="beyond Zhou 2023, Table 4",
    params=ZhouParams,
    cases=cases,
    simulate=setting.measure,
    file=__file__,
    runs=30,
    block=setting.BLOCK,
    paired=("radio_m", "loss", "delay"),
    plot=plot,
)
