"""What can be said of a mission without flying it."""

from __future__ import annotations

import re
import socket
from dataclasses import dataclass
from math import degrees

from planners.terrain import steep_share
from uavbridge.config import Member, Mission
from uavbridge.config.radio import radio_of
from uavbridge.errors import ConfigError

_LOOPBACK = "127.0.0.1"
_ROUTER_PATIENCE_S = 2.0


@dataclass(frozen=True, slots=True)
class Understood:
    """A mission in the reader's words, and what follows from it."""

    mission: str
    planner: str
    clock: str
    seed: int
    cells: int
    area_km2: float
    targets: int
    agents: tuple[Member, ...]
    sweep_s: float  # no fleet can fly over all cells faster
    duration_s: float  # the search ends then at the latest
    radio: str  # what is emulated
    ground: str  # empty: level
    by_signal: bool  # targets give signals: no cells are looked at
    speed: float | None  # mission seconds per second; None: as fast as the machine can

    def lines(self) -> list[str]:
        """One screen of text."""
        pace = "as fast as it can" if self.speed is None else f"{self.speed:g} times real time"
        return [
            f"mission   {self.mission}, planner {self.planner}, seed {self.seed}",
            f"area      {self.area_km2:g} km2 in {self.cells} cells, "
            f"hidden targets: {self.targets}",
            f"clock     {self.clock}, {pace}",
            *([f"ground    {self.ground}"] if self.ground else []),
            f"search    {self._search()}, time limit {self.duration_s:g} s",
            f"radio     {self.radio or 'everybody hears everybody'}",
            f"agents    {len(self.agents)}",
            *(
                f"  {agent.id:>3}  start x {agent.start[0]:g} m, y {agent.start[1]:g} m; "
                f"{_searches(agent)}"
                for agent in self.agents
            ),
        ]

    def _search(self) -> str:
        if self.by_signal:
            return "by the targets' signals"
        return f"{self.sweep_s:.0f} s at best to fly over all cells"


def _searches(agent: Member) -> str:
    if agent.kind == "rover":
        return "a rover, searches on the ground"
    word = "" if agent.kind == "multirotor" else f"a {agent.kind}, "
    return f"{word}searches at {agent.altitude_m:g} m"


def _ground(mission: Mission) -> str:
    """The terrain in words; empty: level."""
    terrain, ground = mission.terrain(), mission.ground
    if terrain is None or ground is None:
        return ""
    low, high = float(terrain.heights.min()), float(terrain.heights.max())
    source = "generated" if ground.file is None else ground.file
    share = steep_share(terrain, ground.beta_rad + 1e-9)
    return (
        f"{source}; heights {low:.0f} to {high:.0f} m, slopes up to "
        f"{degrees(terrain.steepest()):.1f} degrees, {share:.1%} above beta"
    )


def understood(mission: Mission) -> Understood:
    """What a checked mission means."""
    grid, team = mission.grid, mission.team()
    path_m = grid.size * grid.cell_m
    return Understood(
        mission=mission.name,
        planner=mission.planner,
        clock=mission.clock,
        seed=mission.seed,
        cells=grid.size,
        area_km2=grid.size * grid.cell_m**2 / 1e6,
        targets=len(mission.targets),
        agents=team,
        sweep_s=path_m / (len(team) * mission.safety.speed_m_s),
        duration_s=mission.duration,
        radio=radio_of(mission).words(),
        ground=_ground(mission),
        by_signal=mission.signals is not None,
        speed=mission.speed if mission.clock == "paced" else None,
    )


def probe(mission: Mission, name: str) -> None:
    """Try the ports and endpoints that a paced mission names.

    Args:
        mission: a checked mission.
        name: stands for its file in messages.

    Raises:
        ConfigError: one is taken, or the router does not answer.
    """
    if mission.clock == "stepped":
        return
    if mission.simulator.ports != "auto":
        for port in range(mission.simulator.ports, mission.simulator.ports + mission.vehicles):
            _probe_port(socket.SOCK_DGRAM, (_LOOPBACK, port), f"{name}: simulator.ports: UDP")
    if mission.bus.router is not None:
        _probe_router(mission.bus.router, name)
    elif address := _tcp(mission.bus.listen):
        _probe_port(socket.SOCK_STREAM, address, f"{name}: bus.listen: TCP")


def _probe_router(endpoint: str, name: str) -> None:
    address = _tcp(endpoint)
    if address is None:
        return
    try:
        socket.create_connection(address, timeout=_ROUTER_PATIENCE_S).close()
    except OSError as error:
        reason = error.strerror or "no answer"
        raise ConfigError(f"{name}: bus.router: no router at {endpoint}: {reason}") from None


def _tcp(endpoint: str) -> tuple[str, int] | None:
    """Host and port of a zenoh endpoint over TCP; None for others."""
    match = re.fullmatch(r"t(?:cp|ls)/\[?(.+?)\]?:(\d{1,5})(?:[?#].*)?", endpoint)
    return (match[1], int(match[2])) if match else None


def _probe_port(kind: socket.SocketKind, address: tuple[str, int], subject: str) -> None:
    host, port = address
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, kind) as probe_socket:
        if kind == socket.SOCK_STREAM:  # as servers do, for ports that are closing
            probe_socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe_socket.bind(address)
        except OSError as error:
            raise ConfigError(f"{subject} port {port} on {host}: {error.strerror}") from None
