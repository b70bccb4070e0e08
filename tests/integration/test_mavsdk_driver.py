"""The contract of the vehicle seam for the MAVSDK driver, in real time."""

import time

import pytest

pytest.importorskip("mavsdk")

from tests.integration.missions import document, launch, write
from tests.integration.simulator import simulator
from tests.uavbridge.vehicle import test_vehicle_contract as contract
from uavbridge.mavlink.link import memory_pair
from uavbridge.vehicle.api import Done, Net, RestoreNet, SetNet
from uavbridge.vehicle.mavsdk.vehicle import MavsdkVehicle

pytestmark = pytest.mark.integration
TICK_S = 0.006  # wall time of a tick of 50 ms: MAVSDK lives on the wall's


class Flight(contract.Flight):
    """The same vehicle behind MAVSDK, and time that passes."""

    def __init__(self, *, start=contract.START):
        super().__init__("mavlink", start=start)
        near, self.far = memory_pair()
        self.vehicle = MavsdkVehicle(near, 7, origin=contract.ORIGIN)

    def step(self):
        super().step()
        time.sleep(TICK_S)


@pytest.fixture
def flight():
    made = Flight()
    yield made
    made.vehicle.close()


@pytest.fixture
def rough(flight):
    return flight


class TestMavsdk(contract.TestEveryVehicle):
    def test_the_safety_net_is_set_and_put_back(self, flight):
        flight.ready()
        parameters = flight.fleet.pilot.parameters
        before = {name: parameters.get(0, name) for name in ("GF_ACTION", "COM_OF_LOSS_T")}
        net = Net(fence_radius_m=300.0, fence_height_m=80.0, return_height_m=30.0)
        assert flight.do(SetNet(net)) == Done(SetNet(net))
        assert parameters.get(0, "GF_ACTION") == 3
        assert parameters.get(0, "COM_OF_LOSS_T") == 2.0
        assert flight.do(RestoreNet()) == Done(RestoreNet())
        assert {name: parameters.get(0, name) for name in before} == before


@pytest.mark.soak
def test_a_mission_flies_by_mavsdk_beside_a_simulated_one(tmp_path):
    with simulator(
        "--count", "2", "--ports", "shared", "--start-system", "7", "--speed", "4"
    ) as sim:
        url = ("--connect", f"udpin:127.0.0.1:{sim.port}")
        done = launch(
            write(tmp_path), "--vehicles", 3, *url, *url, "--driver", "mavsdk", "--json",
            "--out", tmp_path / "o", "--duration", 15,
        )  # fmt: skip
    assert [agent["state"] for agent in document(done)["agents"]] == ["landed"] * 3, done.stderr
    assert document(done)["failures"] == []
