"""A MAVLink-connected mission bridge for UAV swarm search.

``uavbridge.run`` flies a mission from Python; the command line is ``uavbridge``.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in ``typing``, which would have to be loaded before Ctrl-C is quiet
if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike

    from planners.planner import PlannerKind
    from uavbridge.config import Mission
    from uavbridge.report.result import MissionResult

__all__ = ["run"]


def run(
    mission: str | PathLike[str] | Mission | None = None,
    *,
    planner: str | PlannerKind | None = None,
    clock: str = "stepped",
    out: str | PathLike[str] | None = None,
    overrides: Mapping[str, object] | None = None,
) -> MissionResult:
    """Fly a mission and return what came of it, as arrays.

    Args:
        mission: a mission file, a ``Mission``, or None for the built-in example.
        planner: name of an installed planner, or a ``PlannerKind`` of your own; None: the
            mission's.
        clock: "stepped" (lockstep, as fast as it can) or "paced".
        out: folder for the recording and the report; None: nothing is written.
        overrides: mission keys to replace, such as ``{"seed": 3, "radio.range_m": 200.0}``.

    Returns:
        Series over time, tracks ``{agent: (k, 3)}`` in ENU m, the union of the maps
        (columns, rows), targets, agents, separation; see ``uavbridge.report.result``.

    Raises:
        ConfigError: something in the mission, the overrides or the planner's parameters is wrong.
    """
    from pathlib import Path

    from uavbridge import config, plugins
    from uavbridge.runner import launch

    changes = {**(overrides or {}), "clock": clock}
    known, kind = plugins.planners(), None
    if isinstance(planner, str):
        changes["planner"] = planner
    elif planner is not None:
        kind = planner
        known = {**known, kind.name: kind}
        changes["planner"] = kind.name
    if isinstance(mission, config.Mission):
        loaded = config.override(mission, changes, planners=known)
    else:
        loaded = config.load(mission, changes, planners=known)
    if out is None:
        return launch.fly(loaded, folder=None, kind=kind)
    return launch.fly_and_report(loaded, Path(out), kind=kind)
