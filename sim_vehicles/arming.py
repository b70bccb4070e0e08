"""May this vehicle arm, or change to a mode? If not, why not."""

from __future__ import annotations

from dataclasses import dataclass

from sim_vehicles.modes import Mode
from sim_vehicles.pilot import Pilot


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why something was not done; no reason: nothing is said.

    ``for_good``: asking again later will not help; ``unsupported``: this kind of vehicle
    never does it.
    """

    reason: str
    for_good: bool = False
    unsupported: bool = False


def why_not_arm(pilot: Pilot, i: int) -> str | None:
    """The first check that fails, in a few words; None: it may arm."""
    status, parameters = pilot.status, pilot.parameters
    mode = Mode(int(status.mode[i]))
    reason = _why_not_fly(pilot, i, mode)
    if reason is not None:
        return reason
    if not pilot.modes[mode].armable:
        return f"{pilot.modes[mode].name} mode is not for arming"
    if pilot.charge(i) < max(
        parameters.get(i, "BAT_LOW_THR"), parameters.get(i, "COM_ARM_BAT_MIN")
    ):
        return "low battery"
    if parameters.get(i, "NAV_DLL_ACT") > 0 and (status.gcs_us[i] < 0 or status.gcs_lost[i]):
        return "no connection to the ground station"
    if parameters.get(i, "COM_ARM_MIS_REQ") > 0 and not pilot.plans[i].steps:
        return "no valid mission"
    return None


def why_not_change(pilot: Pilot, i: int, mode: Mode) -> str | None:
    """Why a mode can not be had now; on the ground, disarmed, nearly any can."""
    if mode is Mode.MISSION and not pilot.plans[i].steps:
        return "no valid mission"
    return _why_not_fly(pilot, i, mode) if pilot.status.armed[i] else None


def _why_not_fly(pilot: Pilot, i: int, mode: Mode) -> str | None:
    spec = pilot.modes[mode]
    if spec.needs_sticks:
        return "no remote control"
    if spec.needs_position and pilot.now_us < pilot.status.ready_us[i]:
        return "position estimate not ready"
    if spec.needs_setpoints and not pilot.has_setpoints(i):
        return "no offboard signal"
    if mode is Mode.MISSION and not pilot.plans[i].steps:
        return "no valid mission"
    return None
