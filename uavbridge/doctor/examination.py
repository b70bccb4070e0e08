"""The whole examination: machine, mission, endpoints, vehicles."""

from __future__ import annotations

import re
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib.metadata import version
from typing import Final

from sim_vehicles.codec import Encoder
from uavbridge.clock import PacedClock, pause, to_us
from uavbridge.config import Mission
from uavbridge.doctor.checkup import Checkup
from uavbridge.doctor.clock import clock_finding
from uavbridge.doctor.finding import Diagnosis, Finding, Level, error, ok, warning
from uavbridge.doctor.ports import Protocol, port_finding, remedy_of, why_not
from uavbridge.errors import LinkError, UavbridgeError
from uavbridge.mavlink.identity import COMPONENT, SYSTEM
from uavbridge.mavlink.scout import Survey
from uavbridge.mavlink.urls import Endpoint
from uavbridge.runner.attach import assign, ends_of, keyring_of, open_surveys, refusals
from uavbridge.runner.fitness import Attached, adopt, check, check_speed, check_twins
from uavbridge.runner.leased import Leased
from uavbridge.runner.outcome import versions

LISTEN_S = 2.5  # at least: two heartbeats, twins, the pace of clocks
_LOOK_S = 0.02
_PATIENCE_S = 2.0
_PYTHON = (3, 11)
_TCP = re.compile(r"t(?:cp|ls)/\[?(.+?)\]?:(\d{1,5})(?:[?#].*)?")
_LISTENING: Final[dict[str, Protocol]] = {"udpin": "udp", "tcpin": "tcp"}


def examine(
    mission: Mission, *, adopt_home: bool = False, adopt_speed: bool = False, wait_s: float = 10.0
) -> Diagnosis:
    """Look at everything that a launch of this mission needs; nothing is commanded.

    Args:
        mission: checked.
        adopt_home: its origin is the home of the first vehicle that has an endpoint.
        adopt_speed: it goes as fast as the vehicles' clocks.
        wait_s: wall time to wait for vehicles to be heard and to become ready.
    """
    findings = [*_versions(mission), *_ports(mission), *_router(mission)]
    if mission.bus.router is not None or mission.apart():
        findings.append(clock_finding())
    findings += _vehicles(mission, adopt_home, adopt_speed, wait_s)
    ready = not any(finding.level is Level.ERROR for finding in findings)
    return Diagnosis(mission.name, ready, tuple(findings))


def _versions(mission: Mission) -> Iterator[Finding]:
    found = versions()
    text = ", ".join(f"{name} {number}" for name, number in found.items() if name != "platform")
    if sys.version_info < _PYTHON:
        yield error("versions", text, f"Python {'.'.join(map(str, _PYTHON))} or later")
    else:
        yield ok("versions", text)
    if mission.mavlink.driver == "mavsdk":
        yield from _driver()


def _driver() -> Iterator[Finding]:
    from uavbridge.vehicle.mavsdk.station import import_mavsdk

    try:
        import_mavsdk()
    except UavbridgeError as fault:
        yield error("driver", str(fault), "or fly with --driver uavbridge")
    else:
        yield ok("driver", f"mavsdk {version('mavsdk')}")


def _ports(mission: Mission) -> Iterator[Finding]:
    if mission.clock == "stepped":
        return
    first = mission.simulator.ports
    if first != "auto":
        for port in range(first, first + mission.vehicles):
            yield _own_port(mission.simulator.host, port)
    listen = _TCP.fullmatch(mission.bus.listen)
    if listen and mission.bus.router is None:
        yield port_finding("tcp", listen[1], int(listen[2]), "bus.listen")


def _own_port(host: str, port: int) -> Finding:
    """Where a simulated vehicle is listened to: free, and no other simulator sends there."""
    found = port_finding("udp", host, port, "simulator.ports")
    if found.level is Level.ERROR:
        return found
    try:
        with Leased(()) as leased:
            leased.keep(port)
    except LinkError as fault:
        return error(found.subject, str(fault), "end it, or give simulator.ports another port")
    return found


def _router(mission: Mission) -> Iterator[Finding]:
    router = mission.bus.router
    if router is None:
        stepped = mission.clock == "stepped"
        yield ok(
            "router", "none: stepped time needs none" if stepped else "embedded in the launcher"
        )
        return
    match = _TCP.fullmatch(router)
    if match is None:
        yield warning("router", f"{router}: only tcp and tls can be looked at")
        return
    try:
        socket.create_connection((match[1], int(match[2])), timeout=_PATIENCE_S).close()
    except OSError as fault:
        text = f"{router} does not answer: {fault.strerror or fault}"
        yield error("router", text, f"start one: uavbridge router --listen {router}")
    else:
        yield ok("router", f"{router} answers")
        yield from _attempt("router", lambda: Leased((), (router, mission.name)).close())


def _vehicles(
    mission: Mission, adopt_home: bool, adopt_speed: bool, wait_s: float
) -> Iterator[Finding]:
    ends = ends_of(mission)
    simulated = len(mission.team()) - len(ends)
    if simulated:
        yield ok("simulator", f"{simulated} vehicle(s) are simulated")
    if not ends:
        return
    taken = list(_taken(set(ends.values())))
    if taken:
        yield from taken
        return
    with ExitStack() as stack:
        try:
            surveys = open_surveys(ends, stack, keyring_of(mission))
        except LinkError as fault:
            yield error("endpoint", str(fault), "check the address and who else uses it")
            return
        checkups, now_us = _listen(surveys, len(ends), wait_s)
        vehicles = assign(ends, surveys)
        yield from _attempt("vehicles", lambda: check_twins(mission, vehicles, surveys))
        first = next(iter(vehicles.values()))
        try:
            mission = adopt(mission, vehicles, adopt_home and first.scout is not None, adopt_speed)
        except UavbridgeError as fault:
            yield error("home", str(fault), "wait until the vehicle knows where it is")
        yield from _attempt("speed", lambda: check_speed(vehicles, mission))
        for attached in vehicles.values():
            yield from _vehicle(attached, mission, checkups, now_us, surveys)


def _taken(ends: set[Endpoint]) -> Iterator[Finding]:
    """Ports that endpoints listen on and that somebody else has."""
    for end in sorted({end.place for end in ends}, key=str):
        name = _LISTENING.get(end.kind)
        fault = why_not(name, end.host, end.port) if name is not None and end.port else None
        if fault is not None:
            remedy = remedy_of(fault, "have the vehicle send elsewhere")
            yield error(f"{name} port {end.port}", fault, remedy)


def _listen(
    surveys: dict[Endpoint, Survey], wanted: int, wait_s: float
) -> tuple[dict[tuple[str, int], Checkup], int]:
    """Hear and ask everybody until all is known and all are ready, or patience ends."""
    encoder = Encoder(SYSTEM, COMPONENT)
    checkups: dict[tuple[str, int], Checkup] = {}
    clock = PacedClock()
    while (t_us := clock.now_us()) < to_us(max(wait_s, LISTEN_S)):
        for survey in surveys.values():
            survey.step(t_us)
            for scout in survey.vehicles:
                key = (survey.hub.name, scout.system)
                if key not in checkups:
                    checkups[key] = Checkup(scout, survey.hub, encoder)
                checkups[key].step(t_us)
        known = len(checkups) >= wanted and all(c.done for c in checkups.values())
        ready = all(not c.scout.readiness.waiting_for(t_us, None) for c in checkups.values())
        if known and ready and t_us > to_us(LISTEN_S):
            break
        pause(_LOOK_S)
    return checkups, t_us


def _vehicle(
    attached: Attached,
    mission: Mission,
    checkups: dict[tuple[str, int], Checkup],
    now_us: int,
    surveys: dict[Endpoint, Survey],
) -> Iterator[Finding]:
    subject = f"agent {attached.agent}"
    place = attached.endpoint.place
    if attached.scout is None:
        hub = surveys[place].hub
        trouble = f" ({hub.trouble})" if hub.trouble else ""
        text = f"nobody is heard at {attached.endpoint}{trouble}{refusals(hub)}"
        yield error(subject, text, "start the vehicle, and have it send there")
        return
    yield ok(subject, f"system {attached.system} at {place}")
    yield from _attempt(subject, lambda: check(attached, mission))
    yield from checkups[str(place), attached.system].findings(subject, mission, now_us)


def _attempt(subject: str, look: Callable[[], None]) -> Iterator[Finding]:
    try:
        look()
    except UavbridgeError as fault:
        yield error(subject, str(fault))
