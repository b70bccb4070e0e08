"""The course of aircraft: when they come down."""

import pytest

from tests.uavbridge.agent.test_flight import FlyTo, plan_of
from uavbridge.agent.phases import Phase
from uavbridge.agent.winging import Winging
from uavbridge.safety.envelope import Envelope
from uavbridge.safety.filter import Traffic

LIMITS = Envelope(-500, -500, 500, 500, 15, 200, speed_m_s=28.0, slowest_m_s=18.0)


@pytest.mark.parametrize(
    ("place", "velocity", "lands"),
    [
        ((200.0, 0.0, 60.0), (0.0, 22.0, 0.0), False),  # circles below it
        ((200.0, 0.0, 140.0), (0.0, 22.0, 0.0), True),  # above
        ((60.0, 0.0, 0.0), (0.0, 0.0, 0.0), True),  # stands on the ground
        ((60.0, 0.0, 0.0), (0.0, 2.0, 0.0), True),  # drives
        ((5.0, 0.0, 0.0), (0.0, 0.0, 0.0), False),  # stands where it lands
    ],
)
def test_it_lands_when_nobody_circles_below(place, velocity, lands):
    course = Winging(plan_of(FlyTo(None), envelope=LIMITS, return_height_m=100.0))
    course.home = (0.0, 0.0, 0.0)
    leg = course.steer(Phase.HOME, (120.0, 0.0, 100.0), 0, None, [Traffic(2, place, velocity)])
    assert (leg.after is Phase.LAND) is lands
