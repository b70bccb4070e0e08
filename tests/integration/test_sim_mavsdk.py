"""The simulator flown by MAVSDK, a client that knows nothing of us."""

import asyncio
import math
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any

import pytest

pytest.importorskip("mavsdk.asyncio")

from mavsdk.asyncio import ComponentType, Configuration, Mavsdk
from mavsdk.asyncio.plugins.action import ActionAsync, ActionError
from mavsdk.asyncio.plugins.geofence import (
    FenceType,
    GeofenceAsync,
    GeofenceData,
    Point,
    Polygon,
)
from mavsdk.asyncio.plugins.info import InfoAsync
from mavsdk.asyncio.plugins.mission import MissionAsync, MissionPlan
from mavsdk.asyncio.plugins.mission import MissionItem as PlannedItem
from mavsdk.asyncio.plugins.mission_raw import MissionItem, MissionRawAsync
from mavsdk.asyncio.plugins.offboard import OffboardAsync, PositionNedYaw, VelocityNedYaw
from mavsdk.asyncio.plugins.param import ParamAsync
from mavsdk.asyncio.plugins.telemetry import FlightMode, LandedState, TelemetryAsync

from tests.integration.simulator import simulator

pytestmark = pytest.mark.integration
PX4: tuple[str, ...] = ()
# An ArduPilot that streams unasked, as one whose ground station once asked for it.
ARDUPILOT = (
    *("--autopilot", "ardupilot", "--speed", "12"),
    *("--param", "SR0_POSITION=10", "--param", "SR0_EXT_STAT=4", "--param", "SR0_EXTRA1=4"),
)
both_faces = pytest.mark.parametrize("face", [PX4, ARDUPILOT], ids=["px4", "ardupilot"])


async def until(values: AsyncIterator[Any], accept: Callable[[Any], bool], within_s: float = 20.0):
    """The first value that is accepted."""
    async with asyncio.timeout(within_s):
        async for value in values:
            if accept(value):
                return value
    raise AssertionError("the stream ended")


def near(place: tuple[float, float, float], within: float = 1.0) -> Callable[[Any], bool]:
    def accept(value: Any) -> bool:
        at = value.position
        return math.dist((at.north_m, at.east_m, at.down_m), place) < within

    return accept


class Drone:
    """All plugins of one vehicle."""

    def __init__(self, system: Any) -> None:
        self.action = ActionAsync(system)
        self.geofence = GeofenceAsync(system)
        self.info = InfoAsync(system)
        self.mission = MissionRawAsync(system)
        self.planned = MissionAsync(system)
        self.offboard = OffboardAsync(system)
        self.param = ParamAsync(system)
        self.telemetry = TelemetryAsync(system)

    async def mode(self, mode: FlightMode) -> None:
        await until(self.telemetry.subscribe_flight_mode(), lambda value: value == mode)

    async def ready(self) -> None:
        await until(
            self.telemetry.subscribe_health(), lambda h: h.is_armable and h.is_home_position_ok
        )

    async def up(self, height_m: float) -> None:
        await self.ready()
        await self.action.set_takeoff_altitude(height_m)
        await self.action.arm()
        await self.action.takeoff()
        await until(
            self.telemetry.subscribe_position(), lambda p: p.relative_altitude_m > height_m - 0.5
        )

    async def down(self) -> None:
        await until(self.telemetry.subscribe_landed_state(), lambda s: s == LandedState.ON_GROUND)
        await until(self.telemetry.subscribe_armed(), lambda armed: not armed)


def fly(flight: Callable[[Drone], Awaitable[None]], *arguments: str) -> None:
    """Start a simulator and give its first vehicle to ``flight``."""

    async def run(port: int) -> None:
        kind = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
        async with Mavsdk(kind) as sdk:
            await sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
            await flight(Drone(await sdk.first_autopilot(timeout_s=10)))

    with simulator("--speed", "8", *arguments) as sim:
        asyncio.run(run(sim.port))


def test_health_identity_and_parameters():
    async def flight(drone: Drone) -> None:
        await drone.ready()
        health = await drone.telemetry.health()
        for name in (
            "is_gyrometer_calibration_ok",
            "is_accelerometer_calibration_ok",
            "is_magnetometer_calibration_ok",
            "is_local_position_ok",
            "is_global_position_ok",
            "is_home_position_ok",
            "is_armable",
        ):
            assert getattr(health, name), name
        assert (await drone.info.get_version()).flight_sw_major == 1
        origin = await drone.telemetry.get_gps_global_origin()
        assert origin.latitude_deg == pytest.approx(47.397742)
        battery = await until(drone.telemetry.subscribe_battery(), lambda _: True)
        assert battery.remaining_percent > 90
        gps = await until(drone.telemetry.subscribe_gps_info(), lambda _: True)
        assert gps.fix_type >= 3

        assert await drone.param.get_param_float("MPC_XY_VEL_MAX") == 12.0
        await drone.param.set_param_float("MPC_XY_VEL_MAX", 7.5)
        assert await drone.param.get_param_float("MPC_XY_VEL_MAX") == 7.5
        await drone.param.set_param_int("SYS_AUTOSTART", 4002)
        assert await drone.param.get_param_int("SYS_AUTOSTART") == 4002
        everything = await drone.param.get_all_params()
        assert len(everything.float_params) > 10

    fly(flight)


@both_faces
def test_takeoff_goto_and_land(face):
    async def flight(drone: Drone) -> None:
        await drone.up(8.0)
        assert await drone.telemetry.in_air()
        with pytest.raises(ActionError, match="FAILED" if face else "DENIED"):
            await drone.action.disarm()
        await drone.action.goto_location(47.397922, 8.545594, 488.0 + 12.0, 0.0)
        await until(drone.telemetry.subscribe_position_velocity_ned(), near((20.0, 0.0, -12.0)), 40)
        await drone.action.hold()
        await drone.mode(FlightMode.HOLD)
        await drone.action.land()
        await drone.mode(FlightMode.LAND)
        await drone.down()

    fly(flight, *face)


@both_faces
def test_offboard_position_velocity_and_return(face):
    async def flight(drone: Drone) -> None:
        await drone.up(6.0)
        await drone.offboard.set_position_ned(PositionNedYaw(15.0, -10.0, -8.0, 90.0))
        await drone.offboard.start()
        await drone.mode(FlightMode.OFFBOARD)
        moves = drone.telemetry.subscribe_position_velocity_ned
        await until(moves(), near((15.0, -10.0, -8.0)))
        await until(
            drone.telemetry.subscribe_attitude_euler(), lambda e: abs(e.yaw_deg - 90.0) < 5.0
        )
        await drone.offboard.set_velocity_ned(VelocityNedYaw(0.0, 2.0, 0.0, 90.0))
        await until(moves(), lambda m: abs(m.velocity.east_m_s - 2.0) < 0.2)
        await drone.offboard.stop()
        await drone.mode(FlightMode.HOLD)
        await drone.action.return_to_launch()
        await drone.mode(FlightMode.RETURN_TO_LAUNCH)
        await drone.down()
        await until(moves(), near((0.0, 0.0, 0.0)))

    fly(flight, *face)


@both_faces
def test_missions_go_up_come_down_and_are_flown(face):
    def item(seq: int, command: int, north_m: float, height_m: float) -> MissionItem:
        latitude = round((47.397742 + north_m / 111_170) * 1e7)
        first = 1 if seq == 0 else 0
        return MissionItem(
            seq, 6, command, first, 1, 0.0, 1.0, 0.0, math.nan, latitude, 85455940, height_m, 0
        )

    takeoff, waypoint = 22, 16
    rows = [(takeoff, 0.0, 10.0), (waypoint, 15.0, 10.0), (waypoint, 30.0, 12.0)]
    if face:  # ArduPilot's first item is home
        rows.insert(0, (waypoint, 0.0, 0.0))
    items = [item(seq, *row) for seq, row in enumerate(rows)]

    async def flight(drone: Drone) -> None:
        await drone.ready()
        await drone.mission.upload_mission(items)
        back = await drone.mission.download_mission()
        first = 1 if face else 0  # its home is where it stands
        assert [(i.seq, i.command, i.x, i.y, i.z) for i in back[first:]] == [
            (i.seq, i.command, i.x, i.y, i.z) for i in items[first:]
        ]
        await drone.action.arm()
        await drone.mission.start_mission()
        await drone.mode(FlightMode.MISSION)
        await until(
            drone.telemetry.subscribe_position_velocity_ned(), near((30.0, 0.0, -12.0), 2.0), 40
        )
        await drone.mission.clear_mission()
        left = list(await drone.mission.download_mission())
        assert len(left) == first  # MAVSDK leaves ArduPilot its home
        await drone.action.land()
        await drone.down()

    fly(flight, *face)


@both_faces
def test_geofences_hold_it_back(face):
    """A square of 60 m about home, and an order to leave it."""

    def corner(north_m: float, east_m: float) -> Point:
        return Point(47.397742 + north_m / 111_170, 8.545594 + east_m / 75_300)

    corners = [corner(-30, -30), corner(30, -30), corner(30, 30), corner(-30, 30)]
    fence = GeofenceData([Polygon(corners, FenceType.INCLUSION)], [])
    action = "GF_ACTION" if not face else "FENCE_ACTION"

    async def flight(drone: Drone) -> None:
        await drone.ready()
        await drone.geofence.upload_geofence(fence)
        await drone.param.set_param_int(action, 1 if face else 3)  # return
        if face:
            await drone.param.set_param_int("FENCE_ENABLE", 1)
        await drone.up(8.0)
        await drone.action.goto_location(47.397742 + 80 / 111_170, 8.545594, 488.0 + 8.0, 0.0)
        await drone.mode(FlightMode.RETURN_TO_LAUNCH)
        await drone.down()
        await drone.geofence.clear_geofence()

    fly(flight, *face)


def test_a_rover_goes_where_it_is_told():
    async def flight(drone: Drone) -> None:
        await drone.ready()
        await drone.action.arm()
        await drone.action.goto_location(47.397922, 8.545594, 488.0, 0.0)
        moves = drone.telemetry.subscribe_position_velocity_ned
        await until(moves(), near((20.0, 0.0, 0.0), 1.0))
        await drone.offboard.set_velocity_ned(VelocityNedYaw(0.0, 3.0, 0.0, 90.0))
        await drone.offboard.start()
        await until(moves(), lambda m: abs(m.velocity.east_m_s - 3.0) < 0.2)
        await drone.offboard.stop()
        await drone.action.return_to_launch()
        await drone.down()

    fly(flight, "--kind", "rover")


def test_many_vehicles_on_one_port_are_all_found():
    async def run(port: int) -> None:
        kind = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
        async with Mavsdk(kind) as sdk:
            await sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
            async with asyncio.timeout(20):
                while len(await sdk.get_systems()) < 12:
                    await asyncio.sleep(0.05)
            drones = [Drone(system) for system in await sdk.get_systems()]
            await asyncio.gather(*(drone.ready() for drone in drones))
            await asyncio.gather(*(drone.action.arm() for drone in drones))
            await asyncio.gather(*(until(d.telemetry.subscribe_armed(), bool) for d in drones))

    with simulator("--count", "12", "--speed", "2") as sim:
        asyncio.run(run(sim.port))


def test_the_mission_plugin_with_speeds_photos_and_gimbal():
    def item(north_m: float, **more: Any) -> PlannedItem:
        return PlannedItem(
            latitude_deg=47.397742 + north_m / 111_170,
            longitude_deg=8.545594,
            relative_altitude_m=10.0,
            speed_m_s=8.0,
            is_fly_through=True,
            **more,
        )

    plan = MissionPlan(
        [
            item(15.0, gimbal_pitch_deg=-60.0, gimbal_yaw_deg=0.0),
            item(30.0, camera_action=PlannedItem.CameraAction.TAKE_PHOTO, loiter_time_s=1.0),
            item(15.0),
        ]
    )

    async def flight(drone: Drone) -> None:
        await drone.ready()
        await drone.planned.set_return_to_launch_after_mission(True)
        await drone.planned.upload_mission(plan)
        back = await drone.planned.download_mission()
        assert [each.latitude_deg for each in back.mission_items] == pytest.approx(
            [each.latitude_deg for each in plan.mission_items]
        )
        await drone.action.arm()
        await drone.planned.start_mission()
        progress = drone.planned.subscribe_mission_progress()
        await until(progress, lambda p: p.current == p.total == 3, 30)
        await drone.mode(FlightMode.RETURN_TO_LAUNCH)
        await drone.down()

    fly(flight)
