"""The autopilot's local frame against geodesy."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_vehicles.geodesy import Geodetic, to_enu, to_geodetic, yaw_enu_from_ned
from uavbridge.mavlink.local_frame import LocalFrame, heading_to_yaw, shifted

latitudes = st.floats(-85.0, 85.0)
longitudes = st.floats(-180.0, 180.0)
metres = st.floats(-2000.0, 2000.0)
places = st.builds(Geodetic, latitudes, longitudes, st.floats(-100.0, 4000.0))
vectors = st.tuples(metres, metres, metres)


@given(places, vectors, vectors)
def test_same_place_as_by_geodesy(mission: Geodetic, offset: tuple, ned: tuple) -> None:
    local = shifted(mission, offset)
    frame = LocalFrame(local, mission)
    n, e, d = ned
    expected = to_enu(*to_geodetic(np.array([e, n, -d]), local), mission)
    np.testing.assert_allclose(frame.to_mission(n, e, d), expected, atol=1e-5)


@given(places, vectors, vectors)
def test_there_and_back(mission: Geodetic, offset: tuple, point: tuple) -> None:
    frame = LocalFrame(shifted(mission, offset), mission)
    np.testing.assert_allclose(frame.to_local(*frame.to_mission(*point)), point, atol=1e-5)
    back = frame.velocity_to_local(*frame.velocity_to_mission(*point))
    np.testing.assert_allclose(back, point, atol=1e-5)


@given(places, vectors)
def test_velocities_keep_their_size(mission: Geodetic, velocity: tuple) -> None:
    frame = LocalFrame(shifted(mission, (900.0, -400.0, 30.0)), mission)
    turned = frame.velocity_to_mission(*velocity)
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(velocity), abs=1e-5)


@given(st.floats(-10.0, 10.0))
def test_yaw_as_in_geodesy(angle: float) -> None:
    assert heading_to_yaw(angle) == pytest.approx(float(yaw_enu_from_ned(angle)))
    assert -pi <= heading_to_yaw(angle) < pi


def test_north_is_north() -> None:
    home = Geodetic(47.397742, 8.545594, 488.0)
    frame = LocalFrame(home, home)
    np.testing.assert_allclose(frame.to_mission(1.0, 2.0, -3.0), (2.0, 1.0, 3.0), atol=1e-6)
    higher = LocalFrame(Geodetic(47.397742, 8.545594, 500.0), home)
    np.testing.assert_allclose(higher.to_mission(0.0, 0.0, 0.0), (0.0, 0.0, 12.0), atol=1e-6)
