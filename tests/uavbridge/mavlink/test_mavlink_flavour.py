"""What a heartbeat says, and what each autopilot is asked for."""

from __future__ import annotations

import numpy as np
import pytest

from sim_vehicles.codec import mav
from uavbridge.mavlink.ardupilot import ARDUCOPTER, ARDUPLANE, ARDUROVER
from uavbridge.mavlink.commands import Order
from uavbridge.mavlink.flavour import PX4, Flavour, flavour_of
from uavbridge.mavlink.plan import SetParameter
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Disarm,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    ReturnHome,
    SetVelocity,
    TakeOff,
)

COMMANDS: tuple[Command, ...] = (
    Arm(), Disarm(), TakeOff(10.0), Follow(), HoldPosition(), LandHere(), ReturnHome()
)  # fmt: skip


@pytest.mark.parametrize(
    ("custom_mode", "mode", "text"),
    [  # as recorded from PX4 1.17
        (50593792, Mode.HOLD, "AUTO.LOITER"),
        (33816576, Mode.TAKEOFF, "AUTO.TAKEOFF"),
        (393216, Mode.OFFBOARD, "OFFBOARD"),
        (84148224, Mode.RETURN, "AUTO.RTL"),
        (4 << 16 | 6 << 24, Mode.LAND, "AUTO.LAND"),
        (3 << 16, Mode.MANUAL, "POSCTL"),
        (77 << 16, Mode.UNKNOWN, "mode 77.0"),
    ],
)
def test_px4_modes(custom_mode: int, mode: Mode, text: str) -> None:
    assert PX4.mode(custom_mode) == (mode, text)


def test_copter_modes() -> None:
    assert ARDUCOPTER.mode(4) == (Mode.OFFBOARD, "GUIDED")
    assert ARDUCOPTER.mode(6) == (Mode.RETURN, "RTL")
    assert ARDUCOPTER.mode(99) == (Mode.UNKNOWN, "mode 99")


@pytest.mark.parametrize("flavour", [PX4, ARDUCOPTER], ids=lambda flavour: flavour.name)
@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: type(command).__name__)
def test_every_command_has_a_plan_with_a_sign_of_success(
    flavour: Flavour, command: Command
) -> None:
    plan = flavour.plan(command)
    assert any(isinstance(step, Order) for step in plan.steps)
    assert (plan.mode is None) == isinstance(command, Arm | Disarm)


@pytest.mark.parametrize("flavour", [PX4, ARDUCOPTER], ids=lambda flavour: flavour.name)
def test_the_mode_asked_for_is_the_mode_waited_for(flavour: Flavour) -> None:
    for command in (Follow(), HoldPosition(), LandHere(), ReturnHome()):
        plan = flavour.plan(command)
        (order,) = [step for step in plan.steps if isinstance(step, Order)]
        main, sub = round(order.params[1]), round(order.params[2])
        custom_mode = main << 16 | sub << 24 if flavour is PX4 else main
        assert flavour.mode(custom_mode)[0] is plan.mode


def test_px4_takes_off_to_its_parameter() -> None:
    setting, order = PX4.plan(TakeOff(12.0)).steps
    assert setting == SetParameter("MIS_TAKEOFF_ALT", 12.0)
    assert isinstance(order, Order)
    assert order.command == mav.MAV_CMD_NAV_TAKEOFF


def test_copter_takes_off_in_guided() -> None:
    mode, order = ARDUCOPTER.plan(TakeOff(12.0)).steps
    assert isinstance(mode, Order)
    assert isinstance(order, Order)
    assert mode.params[1] == 4
    assert order.params[6] == 12.0


def test_a_setpoint_is_no_command() -> None:
    with pytest.raises(ValueError, match="is no command"):
        PX4.plan(SetVelocity(np.zeros(3)))


def test_heartbeats_choose() -> None:
    quad = mav.MAV_TYPE_QUADROTOR
    assert flavour_of(mav.MAV_AUTOPILOT_PX4, quad) is PX4
    assert flavour_of(mav.MAV_AUTOPILOT_ARDUPILOTMEGA, quad) is ARDUCOPTER
    assert flavour_of(mav.MAV_AUTOPILOT_ARDUPILOTMEGA, mav.MAV_TYPE_GROUND_ROVER) is ARDUROVER
    assert flavour_of(mav.MAV_AUTOPILOT_ARDUPILOTMEGA, mav.MAV_TYPE_FIXED_WING) is ARDUPLANE
    boat = flavour_of(mav.MAV_AUTOPILOT_ARDUPILOTMEGA, mav.MAV_TYPE_SUBMARINE)
    assert boat == "ArduPilot vehicle of type 12 (submarine) is not supported"
    other = flavour_of(mav.MAV_AUTOPILOT_GENERIC, quad)
    assert other == "autopilot 0 (generic) is not supported: PX4 and ArduPilot are"
