"""What the autopilots report of themselves: their status in the numbers of MAVLink."""

from __future__ import annotations

from typing import Final

import numpy as np

from sim_vehicles.autopilot import Autopilot
from sim_vehicles.codec import mav
from sim_vehicles.legs import DESCEND
from sim_vehicles.modes import Mode
from sim_vehicles.streams import SENSORS, Ints, TelemetrySnapshot

_POSITION: Final[int] = (
    mav.MAV_SYS_STATUS_SENSOR_GPS
    | mav.MAV_SYS_STATUS_AHRS
    | mav.MAV_SYS_STATUS_SENSOR_XY_POSITION_CONTROL
)
_TAKEOFF: Final = int(Mode.TAKEOFF)
_PREARM: Final[int] = mav.MAV_SYS_STATUS_PREARM_CHECK


class Report:
    """Keeps a telemetry snapshot true to the autopilots.

    Attributes:
        snapshot: what telemetry reports; its arrays are written in place.
    """

    def __init__(self, pilot: Autopilot) -> None:
        n = len(pilot.status.mode)
        self._pilot = pilot
        craft = pilot.craft
        flavour, has = craft.flavour, craft.modes
        self._custom: Ints = np.array(
            [flavour.custom_mode(mode) if mode in has else 0 for mode in Mode], dtype=np.int64
        )
        self._base: Ints = np.array(
            [flavour.base_mode(mode, armed=False) if mode in has else 0 for mode in Mode],
            dtype=np.int64,
        )
        self._armable = np.array([mode in has and has[mode].armable for mode in Mode])
        zeros = np.zeros(n, dtype=np.int64)
        self.snapshot = TelemetrySnapshot(
            states=pilot.states,
            setpoints=pilot.setpoints,
            armed=pilot.status.armed,
            base_mode=zeros,
            custom_mode=zeros.copy(),
            system_status=zeros.copy(),
            landed_state=zeros.copy(),
            sensors_present=zeros + SENSORS,
            sensors_health=zeros.copy(),
            autopilot=zeros + flavour.autopilot,
            vehicle_type=zeros + craft.mav_type,
            mission_item=zeros.copy(),
            mission_count=zeros.copy(),
            gps_lost=pilot.status.gps_lost,
        )
        self.update()

    def update(self) -> None:
        """Bring the snapshot up to date."""
        out, status = self.snapshot, self._pilot.status
        mode, armed = status.mode, status.armed
        np.take(self._base, mode, out=out.base_mode)
        np.take(self._custom, mode, out=out.custom_mode)
        ready = status.ready_us <= self._pilot.now_us
        able = ready & self._armable[mode] & (status.battery_level == 0)
        able &= self._pilot.states.battery >= self._pilot.parameters.column("BAT_LOW_THR")
        out.sensors_health[:] = SENSORS
        if not able.all():
            out.sensors_health[~able] &= ~_PREARM
            out.sensors_health[~ready] &= ~_POSITION
        states = self._pilot.craft.flavour.states
        if not armed.any():
            out.system_status[:] = np.where(able, states.ready, states.unready)
            out.landed_state[:] = mav.MAV_LANDED_STATE_ON_GROUND
            return
        off = np.where(able, states.ready, states.unready)
        on = np.where(status.landed, states.grounded, mav.MAV_STATE_ACTIVE)
        on[status.failsafe > 1] = mav.MAV_STATE_CRITICAL
        np.copyto(out.system_status, np.where(armed, on, off))
        landed_state = out.landed_state
        landed_state[:] = mav.MAV_LANDED_STATE_IN_AIR
        landed_state[mode == _TAKEOFF] = mav.MAV_LANDED_STATE_TAKEOFF
        landed_state[self._pilot.legs.kind == DESCEND] = mav.MAV_LANDED_STATE_LANDING
        landed_state[status.landed] = mav.MAV_LANDED_STATE_ON_GROUND

    def plan(self, i: int) -> None:
        """Vehicle ``i`` has another mission, or another current step."""
        plan = self._pilot.plans[i]
        self.snapshot.mission_item[i] = plan.current
        self.snapshot.mission_count[i] = len(plan.steps)
