"""Frames and angles: pymap3d as oracle, and there and back."""

from math import pi

import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_vehicles.geodesy import (
    Geodetic,
    LocalGeodesy,
    enu_from_ned,
    ned_from_enu,
    to_enu,
    to_geodetic,
    yaw_enu_from_ned,
    yaw_ned_from_enu,
)

ZURICH = Geodetic(47.397742, 8.545594, 488.0)
metres = st.floats(-9000, 9000)
origins = st.builds(Geodetic, st.floats(-69, 69), st.floats(-180, 180), st.floats(-100, 4000))


@given(origins, metres, metres, st.floats(-500, 3000))
def test_there_and_back(origin, east, north, up):
    back = to_enu(*to_geodetic([east, north, up], origin), origin)
    np.testing.assert_allclose(back, [east, north, up], atol=1e-5)


def test_shapes_follow_the_input():
    latitude, longitude, altitude = to_geodetic(np.zeros((4, 5, 3)), ZURICH)
    assert latitude.shape == longitude.shape == altitude.shape == (4, 5)
    assert to_enu(latitude, longitude, altitude, ZURICH).shape == (4, 5, 3)
    assert to_enu(47.0, 8.0, 0.0, ZURICH).shape == (3,)


def test_north_and_east_are_where_they_should_be():
    latitude, longitude, altitude = to_geodetic([[0, 1000, 0], [1000, 0, 0], [0, 0, 50]], ZURICH)
    assert latitude[0] > ZURICH.latitude_deg
    assert longitude[0] == pytest.approx(ZURICH.longitude_deg, abs=1e-9)
    assert longitude[1] > ZURICH.longitude_deg
    assert altitude[2] == pytest.approx(538.0)


def test_the_date_line_is_no_wall():
    east_of_it = to_enu(0.0, -179.999, 0.0, Geodetic(0.0, 179.999))
    assert east_of_it[0] == pytest.approx(222.6, abs=0.1)
    longitude = to_geodetic([222.6, 0.0, 0.0], Geodetic(0.0, 179.999))[1]
    assert longitude == pytest.approx(-179.999, abs=1e-5)
    assert LocalGeodesy(Geodetic(0.0, 179.999)).to_geodetic(np.array([[222.6, 0.0, 0.0]]))[
        0, 1
    ] == pytest.approx(-179.999, abs=1e-5)


@pytest.mark.parametrize("bad", [(91, 0, 0), (0, 181, 0), (float("nan"), 0, 0), (0, 0, np.inf)])
def test_no_place_on_earth(bad):
    with pytest.raises(ValueError, match="must be"):
        Geodetic(*bad)


@given(origins, st.integers(0, 2**32 - 1))
def test_the_quick_way_is_within_a_millimetre(origin, seed):
    enu = np.random.default_rng(seed).uniform(-1, 1, (20, 3)) * [9e3, 9e3, 3e3]
    back = to_enu(*LocalGeodesy(origin).to_geodetic(enu).T, origin)
    np.testing.assert_allclose(back, enu, atol=1e-3)


@pytest.mark.parametrize("origin", [ZURICH, Geodetic(89.0, 10.0), Geodetic(-75.0, 179.9999)])
def test_far_places_and_poles_go_the_long_way(origin):
    enu = np.array([[40e3, -60e3, 100.0], [1.0, 2.0, 3.0]])
    expected = np.column_stack(pymap3d.enu2geodetic(*enu.T, *_tuple(origin)))
    np.testing.assert_allclose(LocalGeodesy(origin).to_geodetic(enu), expected)


def _tuple(origin: Geodetic) -> tuple[float, float, float]:
    return origin.latitude_deg, origin.longitude_deg, origin.altitude_m


def test_ned_and_enu():
    np.testing.assert_array_equal(ned_from_enu([1.0, 2.0, 3.0]), [2.0, 1.0, -3.0])
    np.testing.assert_array_equal(enu_from_ned([[2.0, 1.0, -3.0]]), [[1.0, 2.0, 3.0]])
    assert not np.signbit(ned_from_enu(np.zeros(3))).any()  # -0.0 costs bytes on the wire
    lone = ned_from_enu([np.nan, 1.0, 2.0])
    np.testing.assert_array_equal(lone, [1.0, np.nan, -2.0])


@given(st.floats(-20, 20))
def test_yaw_and_heading_are_each_other_s_mirror(yaw):
    heading = yaw_ned_from_enu(yaw)
    assert -pi <= heading < pi
    assert np.cos(yaw_enu_from_ned(heading) - yaw) == pytest.approx(1.0)


def test_headings_of_the_compass():
    np.testing.assert_allclose(yaw_ned_from_enu([pi / 2, 0.0, -pi / 2]), [0.0, pi / 2, -pi])
