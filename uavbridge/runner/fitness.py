"""Can these vehicles fly this mission together? Whatever can not is an error before arming."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace

from sim_vehicles.geodesy import Geodetic, to_enu
from uavbridge.config import Mission
from uavbridge.config.tables import Home
from uavbridge.errors import ConfigError, VehicleError
from uavbridge.mavlink.hub import Hub
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.scout import Scout, Survey
from uavbridge.mavlink.urls import Endpoint
from uavbridge.runner import assemble

FARTHEST_M = 5000.0
CLEAR_M = 5.0  # over the highest home, below the lowest height flown at
DEEPEST_M = 50.0  # a home below the mission's: above it heights over ground would be far more
_SAME_SPEED = 1.5  # clocks that differ by less go at one speed


@dataclass(frozen=True, slots=True, eq=False)
class Attached:
    """One agent's vehicle."""

    agent: int
    endpoint: Endpoint
    system: int
    link: Link
    scout: Scout | None  # None: never heard

    @property
    def where(self) -> str:
        """Endpoint and system, for messages."""
        return f"{self.endpoint.place}, system {self.system}"


def check_twins(
    mission: Mission, vehicles: dict[int, Attached], surveys: dict[Endpoint, Survey]
) -> None:
    """No system id twice: on one port, on two, or with one that we simulate. Or VehicleError."""
    sources: dict[int, list[str]] = {}
    for survey in surveys.values():
        for scout in survey.vehicles:
            sources.setdefault(scout.system, []).extend(sources_of(survey.hub, scout.system))
    for attached in vehicles.values():
        found = sources.get(attached.system, [])
        if len(found) > 1:
            raise VehicleError(
                f"two vehicles have system id {attached.system}: {' and '.join(found)}"
            )
    simulated = {m.id for m in mission.team() if mission.endpoint(m.id) is None}
    for attached in vehicles.values():
        if attached.scout is not None and attached.system in simulated:
            raise VehicleError(
                f"two vehicles have system id {attached.system}: {attached.endpoint.place} and the "
                f"simulated one of agent {attached.system}"
            )


def sources_of(hub: Hub, system: int) -> list[str]:
    """Where a system is heard from; more than one: two vehicles with one id."""
    peer = hub.peers.get(system)
    if peer is None or peer.address is None:
        return [hub.name]
    addresses = sorted(peer.rivals) or [peer.address]
    return [f"{hub.name} from {host}:{port}" for host, port in addresses]


def adopt(
    mission: Mission, vehicles: dict[int, Attached], adopt_home: bool, adopt_speed: bool
) -> Mission:
    """The mission with the first vehicle's home, and as fast as their clocks go."""
    home, speed = mission.home, mission.speed
    if adopt_home:
        first = next(iter(vehicles.values()))
        place = None if first.scout is None else first.scout.start
        if place is None:
            raise VehicleError(f"agent {first.agent}: no home position from {first.where}")
        home = Home(
            latitude_deg=place.latitude_deg,
            longitude_deg=place.longitude_deg,
            altitude_m=place.altitude_m,
        )
    rates = [a.scout.rate for a in vehicles.values() if a.scout and a.scout.rate]
    if adopt_speed and rates:
        speed = _round(float(np.median(rates)))
    return replace(mission, home=home, speed=speed)


def _round(rate: float) -> float:
    """The speed that was asked of a simulator whose clock goes at this rate."""
    return 1.0 if 1 / _SAME_SPEED < rate < _SAME_SPEED else float(f"{rate:.2g}")


def check(attached: Attached, mission: Mission, *, resumes: bool = False) -> None:
    """Raises VehicleError if this vehicle can not fly this mission."""
    scout, subject = attached.scout, f"agent {attached.agent} ({attached.where})"
    if scout is None:
        return
    flavour = scout.telemetry.flavour
    if isinstance(flavour, str):
        raise VehicleError(f"{subject}: {flavour}")
    if mission.mavlink.driver == "mavsdk" and flavour.kind != "multirotor":
        raise VehicleError(f"{subject}: is a {flavour.kind}; mavlink.driver: mavsdk flies none")
    if scout.telemetry.in_air and not resumes:
        raise VehicleError(f"{subject}: is in the air already; --resume goes on with a mission")
    if scout.signs and mission.mavlink.signing_keys is None:
        raise VehicleError(f"{subject}: obeys only those with its key: give --signing-keys FILE")
    place = scout.start
    if place is None:
        return
    east, north, up = offset(place, mission)
    away_m = float(np.hypot(east, north))
    if away_m > FARTHEST_M:
        raise VehicleError(
            f"{subject}: its home is {away_m / 1000:.1f} km from the mission's, more than "
            f"{FARTHEST_M / 1000:g} km: set [home] to {place.latitude_deg:.6f}, "
            f"{place.longitude_deg:.6f}, or leave the mission out"
        )
    highest_m = mission.safety.altitude_min_m - CLEAR_M
    if not -DEEPEST_M <= up <= highest_m:
        raise VehicleError(
            f"{subject}: its home is {abs(up):.0f} m {'above' if up > 0 else 'below'} the "
            f"mission's ({place.altitude_m:.0f} m and {mission.home.altitude_m:g} m above the "
            f"sea), so heights would not be safe: set home.altitude_m"
        )


def offset(place: Geodetic, mission: Mission) -> tuple[float, float, float]:
    """Metres east, north and up of the mission's origin."""
    where = to_enu(
        place.latitude_deg, place.longitude_deg, place.altitude_m, assemble.origin(mission)
    )
    east, north, up = where.tolist()
    return east, north, up


def check_speed(vehicles: dict[int, Attached], mission: Mission) -> None:
    """Raises ConfigError where the mission's speed is not that of a vehicle's clock."""
    for attached in vehicles.values():
        rate = None if attached.scout is None else attached.scout.rate
        if rate is None or rate <= 0:
            continue
        if not 1 / _SAME_SPEED < rate / mission.speed < _SAME_SPEED:
            raise ConfigError(
                f"speed: the mission goes at {mission.speed:g} times real time, the vehicle of "
                f"agent {attached.agent} at {rate:.2g}: give --speed {_round(rate):g}"
            )
