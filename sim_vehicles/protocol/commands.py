"""Commands: a table of who handles which, and the acknowledgement."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, nan, radians
from typing import Final, TypeAlias

from sim_vehicles.ardupilot.pilot import ArduPilot
from sim_vehicles.ardupilot.plane import ArduPlane
from sim_vehicles.arming import Refusal
from sim_vehicles.codec import Packet, mav
from sim_vehicles.geodesy import yaw_enu_from_ned
from sim_vehicles.modes import Mode
from sim_vehicles.plans import Vector
from sim_vehicles.protocol import requests
from sim_vehicles.protocol.endpoint import Endpoint
from sim_vehicles.protocol.orders import Order
from sim_vehicles.winged.pilot import Px4Plane

ACCEPTED: Final[int] = mav.MAV_RESULT_ACCEPTED
DENIED: Final[int] = mav.MAV_RESULT_DENIED
UNSUPPORTED: Final[int] = mav.MAV_RESULT_UNSUPPORTED
# MAV_CMD_GUIDED_CHANGE_SPEED and so on, of ArduPilot's own dialect
GUIDED_CHANGE_SPEED, GUIDED_CHANGE_ALTITUDE, GUIDED_CHANGE_HEADING = 43000, 43001, 43002
WRONG_FRAME: Final = 9  # MAV_RESULT_COMMAND_UNSUPPORTED_MAV_FRAME
_FORCE: Final = 21196
_FAILURES: Final = (mav.FAILURE_TYPE_OK, mav.FAILURE_TYPE_OFF)
_CRITICAL: Final = 2

Command: TypeAlias = Callable[[Endpoint, Order], int]


def on_command(endpoint: Endpoint, packet: Packet) -> None:
    """COMMAND_LONG or COMMAND_INT: do it, and say what became of it."""
    order = Order.read(packet, endpoint.services.flavour.answers.long_frame)
    handler = COMMANDS.get(order.command)
    result = UNSUPPORTED if handler is None else handler(endpoint, order)
    endpoint.send(
        "COMMAND_ACK",
        command=order.command,
        result=result,
        target_system=packet.system,
        target_component=packet.component,
    )


def on_set_mode(endpoint: Endpoint, packet: Packet) -> None:
    """SET_MODE, the message that DO_SET_MODE replaced; acknowledged as that."""
    mode = endpoint.services.flavour.mode_of(packet.message.custom_mode)
    result = _change(endpoint, mode)
    endpoint.send(
        "COMMAND_ACK",
        command=mav.MAV_CMD_DO_SET_MODE,
        result=result,
        target_system=packet.system,
        target_component=packet.component,
    )


def _said(endpoint: Endpoint, refusal: Refusal | None) -> int:
    """The result that a request came to; a refusal is explained in a text."""
    if refusal is None:
        return ACCEPTED
    if refusal.reason:
        endpoint.pilot.say(endpoint.index, _CRITICAL, refusal.reason)
    if refusal.unsupported:
        return UNSUPPORTED
    return DENIED if refusal.for_good else endpoint.services.flavour.answers.refused


def _change(endpoint: Endpoint, mode: Mode | None) -> int:
    if mode is None or mode not in endpoint.services.craft.modes:
        return endpoint.services.flavour.answers.no_mode
    return _said(endpoint, endpoint.pilot.change_mode(endpoint.index, mode))


def _to(mode: Mode) -> Command:
    def change(endpoint: Endpoint, order: Order) -> int:
        known = mode in endpoint.services.craft.modes
        return _change(endpoint, mode) if known else UNSUPPORTED

    return change


def _set_mode(endpoint: Endpoint, order: Order) -> int:
    if not order.whole(1) & mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
        return DENIED
    mode = endpoint.services.flavour.mode_of_command(order.whole(2), order.whole(3))
    return _change(endpoint, mode)


def _arm(endpoint: Endpoint, order: Order) -> int:
    force = order.whole(2) == _FORCE
    value = order.number(1, nan)
    if value == 1.0:
        return _said(endpoint, endpoint.pilot.arm(endpoint.index, force=force))
    if value == 0.0:
        return _said(endpoint, endpoint.pilot.disarm(endpoint.index, force=force))
    return endpoint.services.flavour.answers.no_arming


def _take_off(endpoint: Endpoint, order: Order) -> int:
    if not order.is_global:
        return WRONG_FRAME
    place = _place(endpoint, order)
    if place is None:
        return DENIED
    return _said(endpoint, endpoint.pilot.take_off(endpoint.index, place[2]))


def _reposition(endpoint: Endpoint, order: Order) -> int:
    if not order.is_global:
        return WRONG_FRAME
    pilot, i = endpoint.pilot, endpoint.index
    place = _place(endpoint, order)
    if place is None:
        return DENIED
    may_change = bool(order.whole(2) & mav.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE)
    heading = order.number(4, nan)
    yaw = float(yaw_enu_from_ned(heading)) if abs(heading) < 1e3 else nan
    circle = abs(
        order.number(3)
    )  # of aircraft, whose yaw says which way round: 1, counter-clockwise
    pilot.legs.set_circle(i, (circle if heading == 1.0 else -circle) if circle else nan)
    result = _said(endpoint, pilot.reposition(i, place, yaw, may_change=may_change))
    speed = order.number(1, -1.0)
    if result == ACCEPTED and speed > 0:
        pilot.legs.set_speed(i, min(speed, 1e3))
    return result


def _turn(endpoint: Endpoint, order: Order) -> int:
    """CONDITION_YAW, which of ours ArduCopter alone has: a heading, or by how much to turn."""
    pilot, i = endpoint.pilot, endpoint.index
    angle, way, relative = radians(order.number(1)), order.number(3), order.number(4)
    if not isinstance(pilot, ArduPilot) or isinstance(pilot, ArduPlane) or pilot.legs.grounded:
        return UNSUPPORTED
    if not (-1.0 <= way <= 1.0 and relative in (0.0, 1.0) and isfinite(angle)):
        return endpoint.services.flavour.answers.refused
    by = angle if way < 0.0 else -angle
    pilot.legs.turn(i, pilot.yaw(i) + by if relative else float(yaw_enu_from_ned(angle)))
    return ACCEPTED


def _change_speed(endpoint: Endpoint, order: Order) -> int:
    speed = order.number(2, -1.0)
    if speed == -1.0:
        return ACCEPTED  # no change
    if speed <= 0.0 and speed != -2.0:
        return DENIED
    endpoint.pilot.legs.set_speed(endpoint.index, nan if speed == -2.0 else min(speed, 1e3))
    return ACCEPTED


def _change_guided(endpoint: Endpoint, order: Order) -> int:
    """GUIDED_CHANGE_SPEED, _ALTITUDE and _HEADING, which ArduPlane alone has."""
    pilot, i = endpoint.pilot, endpoint.index
    if not isinstance(pilot, ArduPlane):
        return UNSUPPORTED
    if order.command == GUIDED_CHANGE_ALTITUDE:
        place = _place(endpoint, order)
        if not order.is_global or place is None or not isfinite(place[2]):
            return DENIED
        return _said(endpoint, pilot.change_height(i, place[2]))
    asked = order.number(2, nan)
    if order.command == GUIDED_CHANGE_SPEED:
        if order.whole(1) != 0 or not 0.0 < asked < 1e3:  # airspeed alone
            return DENIED
        return _said(endpoint, pilot.change_airspeed(i, asked))
    if not 0.0 <= asked < 360.0:
        return DENIED
    return _said(endpoint, pilot.change_heading(i, float(yaw_enu_from_ned(radians(asked)))))


def _start_landing(endpoint: Endpoint, order: Order) -> int:
    """DO_LAND_START, of aircraft."""
    pilot, i = endpoint.pilot, endpoint.index
    if not isinstance(pilot, Px4Plane | ArduPlane):
        return UNSUPPORTED
    return _said(endpoint, pilot.start_landing(i))


def _go_around(endpoint: Endpoint, order: Order) -> int:
    """DO_GO_AROUND, of PX4's aircraft."""
    pilot = endpoint.pilot
    if not isinstance(pilot, Px4Plane):
        return UNSUPPORTED
    return _said(endpoint, pilot.go_around(endpoint.index))


def _change_altitude(endpoint: Endpoint, order: Order) -> int:
    """DO_CHANGE_ALTITUDE, of PX4's aircraft: metres above the sea."""
    pilot = endpoint.pilot
    if not isinstance(pilot, Px4Plane):
        return UNSUPPORTED
    z = order.number(1, nan) - endpoint.services.origin.altitude_m
    return _said(endpoint, pilot.change_height(endpoint.index, z)) if abs(z) < 1e5 else DENIED


def _orbit(endpoint: Endpoint, order: Order) -> int:
    """DO_ORBIT, of PX4's aircraft: a loiter of param 1 metres, below 0 counter-clockwise."""
    pilot, i = endpoint.pilot, endpoint.index
    place = _place(endpoint, order)
    if not isinstance(pilot, Px4Plane):
        return UNSUPPORTED
    if place is None or not order.is_global:
        return DENIED
    radius = order.number(1, nan)
    pilot.legs.set_circle(i, -radius if abs(radius) >= 1.0 else nan)
    return _said(endpoint, pilot.reposition(i, place, nan))


def _set_home(endpoint: Endpoint, order: Order) -> int:
    pilot, i = endpoint.pilot, endpoint.index
    if order.whole(1) == 1:
        pilot.status.home[i] = pilot.states.position[i]
        pilot.status.home_yaw[i] = pilot.states.yaw[i]
        return ACCEPTED
    if not order.is_global:
        return WRONG_FRAME
    place = _place(endpoint, order)
    if place is None or not all(map(isfinite, place)):
        return DENIED
    pilot.status.home[i] = place
    return ACCEPTED


def _pause_or_continue(endpoint: Endpoint, order: Order) -> int:
    value = order.number(1, nan)
    if value not in (0.0, 1.0):
        return DENIED
    return _said(endpoint, endpoint.pilot.pause(endpoint.index, go_on=value == 1.0))


def _start_mission(endpoint: Endpoint, order: Order) -> int:
    pilot, i = endpoint.pilot, endpoint.index
    steps = len(pilot.plans[i].steps)
    first = order.whole(1)
    if steps and not 0 <= first < steps:
        return DENIED
    if steps and (first or not endpoint.services.flavour.home_first):  # ArduPilot goes on
        _go_on_from(endpoint, first)
    return _said(endpoint, pilot.start_mission(i))


def _set_mission_current(endpoint: Endpoint, order: Order) -> int:
    pilot, i = endpoint.pilot, endpoint.index
    step = order.whole(1)
    if step < 0:
        return ACCEPTED  # no change
    if step >= len(pilot.plans[i].steps):
        return DENIED
    _go_on_from(endpoint, step)
    return ACCEPTED


def _go_on_from(endpoint: Endpoint, step: int) -> None:
    endpoint.pilot.set_current(endpoint.index, step)
    endpoint.services.report.plan(endpoint.index)


def _enable_fence(endpoint: Endpoint, order: Order) -> int:
    """DO_FENCE_ENABLE, of autopilots that have a parameter for it."""
    parameters, on = endpoint.pilot.parameters, order.whole(1, -1)
    if parameters.row("FENCE_ENABLE") is None:
        return UNSUPPORTED
    if on not in (0, 1):
        return DENIED
    parameters.set(endpoint.index, "FENCE_ENABLE", on)
    return ACCEPTED


def _inject_failure(endpoint: Endpoint, order: Order) -> int:
    """INJECT_FAILURE: the GPS receiver, off and well again; PX4's, with SYS_FAILURE_EN."""
    parameters, i = endpoint.pilot.parameters, endpoint.index
    if parameters.row("SYS_FAILURE_EN") is None:
        return UNSUPPORTED
    if parameters.get(i, "SYS_FAILURE_EN") == 0:
        return DENIED
    if order.whole(1) != mav.FAILURE_UNIT_SENSOR_GPS or order.whole(2) not in _FAILURES:
        return UNSUPPORTED
    endpoint.pilot.fail_gps(i, lost=order.whole(2) == mav.FAILURE_TYPE_OFF)
    return ACCEPTED


def _terminate(endpoint: Endpoint, order: Order) -> int:
    if order.number(1) > 0.5 and endpoint.pilot.status.armed[endpoint.index]:
        endpoint.pilot.stop_motors(endpoint.index, "Flight terminated")
    return ACCEPTED


def _reboot(endpoint: Endpoint, order: Order) -> int:
    if order.whole(1) not in (0, 1) or order.whole(2) != 0:
        return DENIED
    if order.whole(1) == 0:
        return ACCEPTED  # nothing is to be done
    return _said(endpoint, endpoint.pilot.restart(endpoint.index))


def _store(endpoint: Endpoint, order: Order) -> int:
    """Parameters are kept as long as the simulation lasts: nothing to be done."""
    return ACCEPTED if order.whole(1) in (0, 1) else DENIED


def _place(endpoint: Endpoint, order: Order) -> Vector | None:
    """Where an order leads to, ENU m."""
    home_z = float(endpoint.pilot.status.home[endpoint.index, 2])
    zero_is_here = endpoint.services.flavour.answers.zero_is_here
    return order.place(endpoint.services.origin, home_z, zero_is_here=zero_is_here)


COMMANDS: Final[dict[int, Command]] = {
    mav.MAV_CMD_DO_LAND_START: _start_landing,
    mav.MAV_CMD_DO_GO_AROUND: _go_around,
    mav.MAV_CMD_DO_CHANGE_ALTITUDE: _change_altitude,
    mav.MAV_CMD_DO_ORBIT: _orbit,
    GUIDED_CHANGE_SPEED: _change_guided,
    GUIDED_CHANGE_ALTITUDE: _change_guided,
    GUIDED_CHANGE_HEADING: _change_guided,
    mav.MAV_CMD_NAV_LOITER_UNLIM: _to(Mode.HOLD),
    mav.MAV_CMD_NAV_RETURN_TO_LAUNCH: _to(Mode.RETURN),
    mav.MAV_CMD_NAV_LAND: _to(Mode.LAND),
    mav.MAV_CMD_NAV_TAKEOFF: _take_off,
    mav.MAV_CMD_DO_SET_MODE: _set_mode,
    mav.MAV_CMD_DO_CHANGE_SPEED: _change_speed,
    mav.MAV_CMD_CONDITION_YAW: _turn,
    mav.MAV_CMD_DO_SET_HOME: _set_home,
    mav.MAV_CMD_DO_FENCE_ENABLE: _enable_fence,
    mav.MAV_CMD_DO_FLIGHTTERMINATION: _terminate,
    mav.MAV_CMD_INJECT_FAILURE: _inject_failure,
    mav.MAV_CMD_DO_REPOSITION: _reposition,
    mav.MAV_CMD_DO_PAUSE_CONTINUE: _pause_or_continue,
    mav.MAV_CMD_DO_SET_MISSION_CURRENT: _set_mission_current,
    mav.MAV_CMD_MISSION_START: _start_mission,
    mav.MAV_CMD_COMPONENT_ARM_DISARM: _arm,
    mav.MAV_CMD_RUN_PREARM_CHECKS: requests.prearm_checks,
    mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: _reboot,
    mav.MAV_CMD_PREFLIGHT_STORAGE: _store,
    mav.MAV_CMD_GET_HOME_POSITION: requests.home_position,
    mav.MAV_CMD_GET_MESSAGE_INTERVAL: requests.get_interval,
    mav.MAV_CMD_SET_MESSAGE_INTERVAL: requests.set_interval,
    mav.MAV_CMD_REQUEST_MESSAGE: requests.request_message,
    mav.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: requests.autopilot_version,
}
