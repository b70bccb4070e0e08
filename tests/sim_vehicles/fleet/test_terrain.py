from __future__ import annotations

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from planners.terrain import Terrain
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic

ORIGIN = Geodetic(47.397742, 8.545594, 489.4)
RAMP = Terrain(-50.0, -50.0, 10.0, np.add.outer(np.arange(31.0), np.zeros(11)) * 3.0)  # 0.3 up east


@pytest.mark.parametrize("model", ["multirotor", "perfect"])
def test_homes_and_starts_are_on_the_terrain(model):
    specs = [VehicleSpec(1, (50.0, 0.0, 7.0)), VehicleSpec(2, (100.0, 0.0, 0.0), in_air_m=20.0)]
    fleet = Fleet(specs, origin=ORIGIN, model=model, terrain=RAMP)
    fleet.advance(1_000_000)
    assert fleet.states.position[:, 2] == pytest.approx([30.0, 65.0], abs=0.1)
    assert fleet.states.ground == pytest.approx([30.0, 45.0], abs=0.1)
    assert fleet.pilot.status.home[:, 2] == pytest.approx([30.0, 45.0])
    assert fleet.truth().in_air.tolist() == [False, True]


@pytest.mark.parametrize("model", ["multirotor", "perfect"])
def test_touch_down_is_where_the_ground_is(station, model):
    """Up from 15 m, 60 m east over ground at 33 m, down."""
    gcs = station(model=model, terrain=RAMP)
    gcs.get_ready()
    gcs.fly(1)
    assert gcs.position[2] == pytest.approx(15.0)
    gcs.param("MIS_TAKEOFF_ALT", 40.0)
    assert gcs.mode_to(4, 2) == gcs.arm() == 0
    gcs.fly(60, until=lambda: gcs.mode == "Hold")
    assert gcs.position[2] == pytest.approx(55.0, abs=1.0)
    home = gcs.newest("GLOBAL_POSITION_INT")
    assert home.relative_alt == pytest.approx(40_000, abs=1000)
    gcs.stream = lambda: gcs.setpoint(position=(0.0, 60.0, -40.0))
    gcs.fly(0.5)
    assert gcs.mode_to(6) == 0
    gcs.fly(40, until=lambda: gcs.position[0] > 59.5)
    gcs.stream = None
    assert gcs.command(mavlink.MAV_CMD_NAV_LAND) == 0
    gcs.fly(60, until=lambda: not gcs.armed)
    x, _, z = gcs.position
    assert z == pytest.approx(15.0 + 0.3 * x, abs=0.01)
    assert "Landing detected" in gcs.texts


def test_no_start_is_above_the_ground_where_the_terrain_says_how_high_it_is():
    with pytest.raises(ValueError, match="above the ground"):
        Fleet([VehicleSpec(1, (0.0, 0.0, 5.0))], origin=ORIGIN)
    Fleet([VehicleSpec(1, (0.0, 0.0, 5.0))], origin=ORIGIN, terrain=RAMP)
