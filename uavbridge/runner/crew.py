"""The agents that fly in processes of their own, as their launcher sees them.

It starts those of ``bus.agents_per_process``, waits for those of ``bus.remote``, tells all of
them what is flown and where their vehicles are, and writes down what the bus brings of them.
What they alone know (what each of them heard, its decisions) is in their own recordings.
"""

from __future__ import annotations

import logging
import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf
from pathlib import Path

from msgspec import DecodeError
from msgspec.json import Decoder

from uavbridge.bus import keys
from uavbridge.bus.security import agent_name
from uavbridge.bus.text import read
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import pause, to_s, wall_s
from uavbridge.config import Mission, to_toml
from uavbridge.errors import UavbridgeError
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import EventRecord
from uavbridge.replay.record import ENDED_PHASES, Listener
from uavbridge.report.result import PROCESS, Event
from uavbridge.runner.briefing import Brief
from uavbridge.runner.child import end, spawn
from uavbridge.runner.control import AHEAD_US
from uavbridge.runner.folder import as_flown
from uavbridge.runner.pace import Followed

FOLDER = "agents"
DIED = "its process died"
ROUTER = "router"  # kind of events
CONFIRM_S = 0.1  # wall time by which a token may be missed earlier than the router
REJOIN_S = 1.5  # in which all are back at a router that is back
_LOOK_S = 0.05

_log = logging.getLogger(__name__)
_EVENT = Decoder(EventRecord)


class Crew:
    """All agents of other processes.

    Args:
        mission: with targets.
        agents: their ids; at least one.
        bus: a session of the launcher's.
        recorder: gets what the bus brings of them.
        vehicles: where each simulated vehicle is found, by agent.

    Attributes:
        dead: mission time (us) at which an agent's process died; those that came back not.
    """

    def __init__(
        self,
        mission: Mission,
        agents: frozenset[int],
        bus: ZenohBus,
        recorder: Recorder,
        vehicles: Mapping[int, str],
    ) -> None:
        self.agents = agents
        self._mission = mission
        self._recorder = recorder
        self._children: list[tuple[subprocess.Popen[bytes], list[int]]] = []
        self._followed = Followed(bus)
        self._listener = Listener(recorder)
        self._mailboxes = [bus.subscribe("air/**"), bus.subscribe("state/**")]
        self._refused = bus.subscribe(keys.REFUSED)
        self._tokens = bus.watch(keys.alive("*"))
        self._bus = bus
        self._connected = True
        self._changed_s = -inf
        self._missing: dict[int, float] = {}  # wall time at which an agent's token went
        self.dead: dict[int, int] = {}
        text = to_toml(as_flown(mission.for_agents()))
        self._brief = Brief(bus, text, vehicles, mission.speed)

    def start(self, router: str) -> None:
        """Start the child processes that the mission asks for."""
        size = self._mission.bus.agents_per_process
        if self._mission.security.keys is not None:
            size = 1
        mine = sorted(self.agents - set(self._mission.bus.remote))
        for first in range(0, len(mine), size) if size else ():
            agents = mine[first : first + size]
            self._children.append((self._child(agents, router), agents))

    def _child(self, agents: Sequence[int], router: str) -> subprocess.Popen[bytes]:
        given = [f"--id={agent}" for agent in agents]
        arguments = ["uavbridge", "agent", "-", *given, f"--router={router}"]
        if self._mission.security.keys is not None:
            arguments.append(f"--keys={self._mission.security.keys}/{agent_name(agents[0])}")
        if self._recorder.folder is not None:
            arguments.append(f"--out={recording_of(self._recorder.folder, agents)}")
        child = spawn(arguments)
        assert child.stdin is not None
        child.stdin.write(to_toml(as_flown(self._mission.for_agents())).encode())
        child.stdin.close()
        return child

    def wait(self, stop: Callable[[], bool]) -> frozenset[int]:
        """Wait until all are there, or ``bus.wait_s`` is over; those still missing.

        Raises:
            UavbridgeError: a child ended, or nobody came.
        """
        until_s = wall_s() + self._mission.bus.wait_s
        while missing := self.agents - self._followed.here():
            self._check_children()
            if stop() or wall_s() > until_s:
                break
            pause(_LOOK_S)
            self._followed.poll()
        if missing == self.agents:
            raise UavbridgeError(
                f"bus.wait_s: none of the agents {_listed(missing)} came within "
                f"{self._mission.bus.wait_s:g} s"
            )
        return missing

    def begin(self, now_us: Callable[[], int]) -> None:
        """Mission time has begun."""
        self._brief.begin(now_us)

    def poll(self, t_us: int) -> list[Event]:
        """Write down what came; what happened to these agents since the last call."""
        self._followed.poll()
        events: list[Event] = []
        for mailbox in self._mailboxes:
            for sample in mailbox.drain():
                agent = keys.agent_of(sample.key.removesuffix("/event"))
                if agent not in self.agents:
                    continue
                self._listener.take(sample)
                if sample.key == keys.event(agent):
                    events += _event(agent, sample.data, t_us)
        for sample in self._refused.drain():
            self._listener.event(sample.data)
            events += _event(None, sample.data, t_us)
        return events + self._deaths(t_us)

    def _deaths(self, t_us: int) -> list[Event]:
        """Who died, or came back, by the tokens that end with a process."""
        events = self._router(t_us)
        for sample in self._tokens.drain():
            agent = keys.agent_of(sample.key)
            if agent is None or agent not in self.agents:
                continue
            if not sample.data:
                self._missing.setdefault(agent, wall_s())
                continue
            self._missing.pop(agent, None)
            if self.dead.pop(agent, None) is not None:
                events.append(Event(to_s(t_us), "its process is back", agent, PROCESS))
        for agent in self._lost():
            del self._missing[agent]
            if self._listener.phases.get(agent) not in ENDED_PHASES:
                self.dead[agent] = t_us
                events.append(Event(to_s(t_us), DIED, agent, PROCESS))
        for event in events:
            _log.warning("%s: %s", _who(event.agent), event.text)
            record = EventRecord(event.kind, event.text, event.agent or 0)
            self._recorder.record("event", t_us, record)
        return events

    def _router(self, t_us: int) -> list[Event]:
        """Whether it was lost, or is back."""
        there = self._bus.connected
        if there == self._connected:
            return []
        self._connected, self._changed_s = there, wall_s()
        return [Event(to_s(t_us), "it is back" if there else "it is gone", None, ROUTER)]

    def _lost(self) -> list[int]:
        """Whose tokens are gone, though we and they have had the time to find the router again."""
        now_s = wall_s()
        if not self._connected or now_s < self._changed_s + REJOIN_S:
            return []
        return [a for a, since_s in self._missing.items() if now_s > since_s + CONFIRM_S]

    def allowed_us(self, t_us: int) -> int:
        """How far the simulation may go: not far ahead of the slowest of these agents."""
        there = self.agents - self.dead.keys() - self._missing.keys()
        slowest_us = self._followed.slowest_us(there)
        return t_us + AHEAD_US if slowest_us is None else min(t_us, slowest_us) + AHEAD_US

    def close(self) -> None:
        """End the children: those that have landed by themselves, the others are told to."""
        flying = self.agents - {a for a, p in self._listener.phases.items() if p in ENDED_PHASES}
        for child, agents in self._children:
            if flying & set(agents) and child.poll() is None:
                child.terminate()
        for child, _ in self._children:
            end(child)
        self._children.clear()

    def __enter__(self) -> Crew:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _check_children(self) -> None:
        for child, _ in self._children:
            if child.poll() is not None:
                raise UavbridgeError(
                    f"a process of agents could not start (status {child.returncode})"
                )


def recording_of(folder: Path, agents: Iterable[int]) -> Path:
    """Where the recording of a process of agents goes."""
    return folder / FOLDER / "-".join(map(str, agents))


def _event(agent: int | None, data: bytes, t_us: int) -> list[Event]:
    try:
        record = read(_EVENT, data)
    except DecodeError:
        return []
    _log.log(logging.INFO if agent else logging.WARNING, "%s: %s", _who(agent), record.text)
    return [Event(to_s(t_us), record.text, agent, record.kind)]


def _who(agent: int | None) -> str:
    return "router" if agent is None else f"agent {agent}"


def _listed(agents: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(agents)))
