"""The simulator alone, flown by pymavlink over real sockets."""

import math
import os
import re
import signal
import socket
import subprocess
import time

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mav

from tests.integration.simulator import COMMAND, free_port, simulator

pytestmark = pytest.mark.integration
HOLD, OFFBOARD, LAND, RETURN = (4, 3), (6, 0), (4, 6), (4, 5)
NAN = math.nan


class Station:
    """A ground station on a pymavlink connection."""

    def __init__(self, url: str) -> None:
        self.link = mavutil.mavlink_connection(url, source_system=245, dialect="ardupilotmega")

    def __enter__(self) -> "Station":
        return self

    def __exit__(self, *_: object) -> None:
        self.link.close()

    def expect(self, kind, accept=lambda message: True, *, system=1, timeout_s=20.0):
        """The next message of a kind that is accepted."""
        end = time.monotonic() + timeout_s
        while (left_s := end - time.monotonic()) > 0:
            message = self.link.recv_match(type=kind, blocking=True, timeout=left_s)
            if message and message.get_srcSystem() == system and accept(message):
                return message
        raise AssertionError(f"no such {kind} of vehicle {system} within {timeout_s} s")

    def command(self, command: int, *params: float, system: int = 1) -> int:
        """Send COMMAND_LONG; the result of its acknowledgement."""
        values = [*params, *[NAN] * (7 - len(params))]
        self.link.mav.command_long_send(system, 1, command, 0, *values)
        return self.expect("COMMAND_ACK", lambda m: m.command == command, system=system).result

    def request(self, name: str, *, system: int = 1) -> None:
        """Ask for one message; it and the acknowledgement may come in any order."""
        msgid = getattr(mav, f"MAVLINK_MSG_ID_{name}")
        self.link.mav.command_long_send(system, 1, 512, 0, msgid, *[NAN] * 6)
        wanted = {name, "COMMAND_ACK"}
        while wanted:
            message = self.expect([*wanted], system=system)
            assert getattr(message, "result", 0) == 0
            wanted.discard(message.get_type())

    def mode(self, mode: tuple[int, int]) -> int:
        return self.command(mav.MAV_CMD_DO_SET_MODE, 1, *mode)

    def ready(self) -> None:
        ready = mav.MAV_SYS_STATUS_PREARM_CHECK
        self.expect("SYS_STATUS", lambda m: m.onboard_control_sensors_health & ready)

    def setpoint(self, mask: int, *, place=(0, 0, 0), speed=(0, 0, 0)) -> None:
        self.link.mav.set_position_target_local_ned_send(
            0, 1, 1, mav.MAV_FRAME_LOCAL_NED, mask, *place, *speed, 0, 0, 0, 0, 0
        )

    def follow(self, mask: int, accept, *, place=(0, 0, 0), speed=(0, 0, 0)) -> None:
        """Stream a setpoint until the local position is accepted."""
        for _ in range(400):
            self.setpoint(mask, place=place, speed=speed)
            message = self.link.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=2)
            if message and accept(message):
                return
        raise AssertionError("never there")


def near(place, *, within=1.0):
    return lambda m: math.dist((m.x, m.y, m.z), place) < within


def test_a_flight_by_commands_and_setpoints():
    with simulator("--speed", "10") as sim, Station(f"udpin:127.0.0.1:{sim.port}") as gcs:
        beat = gcs.expect("HEARTBEAT")
        assert (beat.autopilot, beat.type) == (mav.MAV_AUTOPILOT_PX4, mav.MAV_TYPE_QUADROTOR)
        gcs.ready()
        assert gcs.command(mav.MAV_CMD_NAV_TAKEOFF, NAN, NAN, NAN, NAN, NAN, NAN, 500.0) == 0
        assert gcs.command(mav.MAV_CMD_COMPONENT_ARM_DISARM, 1) == 0
        gcs.expect("GLOBAL_POSITION_INT", lambda m: m.relative_alt > 11_000)
        gcs.setpoint(0xDF8, place=(20, 10, -15))
        assert gcs.mode(OFFBOARD) == 0
        gcs.follow(0xDF8, near((20, 10, -15)), place=(20, 10, -15))
        gcs.follow(0xDC7, lambda m: m.vy > 1.8 and abs(m.vx) < 0.5, speed=(0, 2, 0))
        assert gcs.mode(HOLD) == 0
        gcs.expect("LOCAL_POSITION_NED", lambda m: math.hypot(m.vx, m.vy) < 0.2)
        assert gcs.mode(RETURN) == 0
        gcs.expect("HEARTBEAT", lambda m: not m.base_mode & 128, timeout_s=40)
        gcs.expect("LOCAL_POSITION_NED", near((0, 0, 0)))
        gcs.expect("EXTENDED_SYS_STATE", lambda m: m.landed_state == 1)
    assert re.search(r" 0 pieces of garbage", sim.summary)


def test_starting_in_the_air_and_landing():
    with (
        simulator("--speed", "10", "--in-air", "5", "--model", "perfect") as sim,
        Station(f"udpin:127.0.0.1:{sim.port}") as gcs,
    ):
        gcs.expect("EXTENDED_SYS_STATE", lambda m: m.landed_state == 2)
        gcs.expect("LOCAL_POSITION_NED", near((0, 0, -5)))
        assert gcs.mode(LAND) == 0
        gcs.expect("EXTENDED_SYS_STATE", lambda m: m.landed_state == 1)


def test_messages_and_rates_on_request():
    with simulator("--speed", "4") as sim, Station(f"udpin:127.0.0.1:{sim.port}") as gcs:
        gcs.expect("HEARTBEAT")
        for wanted in ("AUTOPILOT_VERSION", "HOME_POSITION", "ATTITUDE_QUATERNION"):
            gcs.request(wanted)
        quaternion = mav.MAVLINK_MSG_ID_ATTITUDE_QUATERNION
        assert gcs.command(mav.MAV_CMD_SET_MESSAGE_INTERVAL, quaternion, 40_000) == 0
        gcs.expect("ATTITUDE_QUATERNION")  # at once; from then on in step with others
        first = gcs.expect("ATTITUDE_QUATERNION").time_boot_ms
        assert gcs.expect("ATTITUDE_QUATERNION").time_boot_ms - first == 40


def test_many_vehicles_share_a_port_and_differ_by_id():
    with simulator("--count", "12", "--speed", "2") as sim:
        assert any("1-12" in line and str(sim.port) in line for line in sim.table)
        with Station(f"udpin:127.0.0.1:{sim.port}") as gcs:
            for system in range(1, 13):
                gcs.expect("HEARTBEAT", system=system)


def test_one_port_each():
    port = free_port()
    with simulator("--count", "2", "--ports", "each", "--start-system", "41", port=port) as sim:
        assert len(sim.table) == 4
        with Station(f"udpin:127.0.0.1:{port + 1}") as gcs:
            gcs.expect("HEARTBEAT", system=42)


def heard_from(receiver: socket.socket) -> tuple[str, int]:
    receiver.settimeout(5)
    return receiver.recvfrom(2048)[1]


def test_whoever_speaks_to_a_vehicle_is_answered():
    with simulator() as sim, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as target:
        target.bind(("127.0.0.1", sim.port))
        vehicle = heard_from(target)
        with Station(f"udpout:{vehicle[0]}:{vehicle[1]}") as other:
            other.link.mav.heartbeat_send(6, 8, 0, 0, 4)
            other.expect("ATTITUDE")
            other.request("AUTOPILOT_VERSION")
        heard_from(target)  # the target still hears


def test_who_sends_garbage_is_not_streamed_to():
    with (
        simulator() as sim,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as target,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vandal,
    ):
        target.bind(("127.0.0.1", sim.port))
        vehicle = heard_from(target)
        vandal.sendto(b"garbage", vehicle)
        vandal.sendto(b"\xfd" * 40, vehicle)
        vandal.settimeout(0.5)
        with pytest.raises(TimeoutError):
            vandal.recv(2048)
        heard_from(target)


def test_garbage_is_dropped_and_counted():
    with (
        simulator("--speed", "5") as sim,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as target,
    ):
        target.bind(("127.0.0.1", sim.port))
        vehicle = heard_from(target)
        for size in (0, 1, 11, 12, 40, 300, 1400, 60_000):
            target.sendto(os.urandom(size), vehicle)
            target.sendto(b"\xfd" * size, vehicle)
        time.sleep(0.2)
        heard_from(target)
    found = re.search(r"in: (\d+) datagrams, (\d+) frames, (\d+) pieces", sim.summary)
    assert found
    assert int(found[1]) == 16
    assert int(found[2]) == 0
    assert int(found[3]) >= 14


@pytest.mark.parametrize("ports", ["each", "shared"])
def test_tcp_clients_connect(ports):
    port = free_port(socket.SOCK_STREAM)
    with simulator("--tcp", "--count", "2", "--ports", ports, port=port) as sim:
        second = 2 if ports == "shared" else 1
        with Station(f"tcp:127.0.0.1:{port}") as gcs:
            gcs.expect("HEARTBEAT")
            gcs.expect("HEARTBEAT", system=second)
            gcs.request("AUTOPILOT_VERSION", system=second)
            gcs.link.port.send(b"no frame at all")
            gcs.request("AUTOPILOT_VERSION", system=second)
    assert "15 pieces of garbage" in sim.summary


def test_a_client_that_does_not_read_loses_frames_and_holds_up_nobody():
    port = free_port(socket.SOCK_STREAM)
    busy = ("--count", "50", "--ports", "shared", "--speed", "60", "--model", "perfect")
    with (
        simulator("--tcp", *busy, "--in-air", port=port) as sim,
        socket.create_connection(("127.0.0.1", port)),
    ):
        time.sleep(2.5)
        with Station(f"tcp:127.0.0.1:{port}") as gcs:
            gcs.expect("HEARTBEAT", system=50)
    dropped = re.search(r"(\d+) dropped", sim.summary)
    assert dropped
    assert int(dropped[1]) > 0


def ended(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*COMMAND, *arguments], capture_output=True, text=True, timeout=30, check=False
    )


def test_a_port_in_use_is_named():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        result = ended("--tcp", "--port", str(port))
    assert result.returncode == 1
    assert f"TCP port {port} on 127.0.0.1 is in use" in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


def test_a_host_that_is_not_there_is_named():
    result = ended("--host", "no.such.host.invalid")
    assert result.returncode == 1
    assert "no.such.host.invalid" in result.stderr
    assert "Traceback" not in result.stderr


def test_it_ends_by_itself_after_a_duration():
    result = ended("--duration", "5", "--speed", "50", "--count", "3", "--port", str(free_port()))
    assert result.returncode == 0
    assert "5.0 s simulated" in result.stdout


def test_sigterm_ends_it_cleanly():
    with simulator() as sim:
        sim.process.send_signal(signal.SIGTERM)
        assert sim.process.wait(timeout=10) == 0
