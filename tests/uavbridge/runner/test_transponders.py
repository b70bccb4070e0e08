"""Vehicles tell where they are when their agents do not."""

import numpy as np
import pytest

from uavbridge.agent.agent import BEACON_US
from uavbridge.bus import keys
from uavbridge.bus.local import LocalHub
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.wire import Beacon, decode_beacon, encode_beacon
from uavbridge.runner.ticks import CONTROL_US
from uavbridge.runner.transponders import Transponders

PLACES = np.array([[10.0, 0.0, 40.0], [0.0, 20.0, 40.0]])
SPEEDS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@pytest.fixture
def air():
    hub = LocalHub()
    bus = hub.bus()
    devices = Transponders((3, 7), hub.bus(), Tiling())
    return devices, bus, bus.subscribe("safety/**")


def shine(bus, agent, t_us):
    bus.publish(
        keys.safety((0, 0), agent), encode_beacon(Beacon(agent, t_us, (0, 0, 9), (0, 0, 0)))
    )


def fly(air, seconds, *, speaking=lambda agent, t_us: True, in_air=(True, True), first_s=0.0):
    """Beacons of the devices alone."""
    devices, bus, heard = air
    own = []
    for t_us in range(int(first_s * 1e6), int((first_s + seconds) * 1e6), CONTROL_US):
        for agent in (3, 7):
            if t_us % BEACON_US == 0 and speaking(agent, t_us):
                shine(bus, agent, t_us)
        devices.step(t_us, PLACES, SPEEDS, np.array(in_air))
        own += [decode_beacon(sample.data) for sample in heard.drain()]
    return [beacon for beacon in own if beacon.t_us % BEACON_US]


def test_silent_while_the_agents_speak(air):
    assert fly(air, 5.0) == []


def test_of_a_vehicle_whose_agent_fell_silent(air):
    own = fly(air, 6.0, speaking=lambda agent, t_us: agent == 3 or t_us < 2e6)
    assert {beacon.sender for beacon in own} == {7}
    times = [beacon.t_us / 1e6 for beacon in own]
    assert 2.8 <= times[0] <= 3.1  # long before the others forget the agent's last one
    assert np.diff(times) == pytest.approx(BEACON_US / 1e6)
    assert own[0].position == (0.0, 20.0, 40.0)
    assert own[0].velocity == (0.0, 0.0, -1.0)


def test_silent_again_when_the_agent_is_back(air):
    assert fly(air, 3.0, speaking=lambda agent, t_us: False)
    fly(air, 0.3, first_s=3.0)
    assert fly(air, 3.0, first_s=3.3) == []


def test_on_the_ground_nobody_need_know(air):
    assert fly(air, 5.0, speaking=lambda *_: False, in_air=(False, False)) == []
    # one that has just taken off is its agent's, for a while
    own = fly(air, 2.0, speaking=lambda *_: False, in_air=(True, False), first_s=5.0)
    assert min(beacon.t_us for beacon in own) > 5.9e6
    assert {beacon.sender for beacon in own} == {3}
