"""What an onlooker knows of a mission, whoever told it: state, and what follows from it."""

from __future__ import annotations

from collections import Counter, deque

import numpy as np

from planners.grid import Grid
from planners.types import F64, Bools
from uavbridge.agent.phases import ENDED
from uavbridge.agent.report import AgentReport
from uavbridge.bus.wire import Vector
from uavbridge.clock import SECOND_US, to_s
from uavbridge.config import Mission
from uavbridge.monitor.events import EventLog
from uavbridge.monitor.finds import Finds
from uavbridge.monitor.groups import Membership, membership
from uavbridge.monitor.maps import Maps
from uavbridge.monitor.snapshot import apart, dropped, rejected
from uavbridge.monitor.watched import RECENT_S, Declared, Happening, Point, Watched, hearing
from uavbridge.recording.topics import MissionRecord
from uavbridge.runner.separation import Floor, SeparationWatch

LEAP_US = 86_400 * SECOND_US  # no mission lasts longer, so no honest clock is so far ahead
REWIND_US = 30 * SECOND_US  # nothing is so late, unless the mission was started anew
REWOUND = 20
_ENDED = {phase.value for phase in ENDED}


class Known:
    """Empty at first.

    Attributes:
        t_us: newest mission time heard of; -1 before anything.
        facts: the mission as it is flown, with the true targets; None until somebody tells.
        agents: by id.
        finds: what agents declared, and reached.
        series: one point a second since the watch began.
        log: of events.
        rejects: what was left out, by reason.
    """

    def __init__(self) -> None:
        self.t_us = -1
        self.record: MissionRecord | None = None
        self.facts: Mission | None = None
        self.agents: dict[int, Watched] = {}
        self.finds = Finds()
        self.series: list[Point] = []
        self.log = EventLog()
        self.rejects: Counter[str] = Counter()
        self.maps = Maps()
        self.separation = SeparationWatch()
        self.floor = Floor()
        self.simulated = False  # the world tells the true positions
        self._stale = 0  # messages from long ago, one after the other
        self._since_us: int | None = None
        self._joining = False  # being told what was before

    @property
    def restarted(self) -> bool:
        """Mission time began anew: this is another flight, for another watch."""
        return self._stale > REWOUND

    @property
    def events(self) -> deque[Happening]:
        """The newest events."""
        return self.log.events

    @property
    def event_count(self) -> int:
        """All events so far; ``events`` ends with number ``event_count - 1``."""
        return self.log.count

    @property
    def grid(self) -> Grid | None:
        """The search area; None until somebody told."""
        return self.maps.grid

    @property
    def found(self) -> int | None:
        """True targets that some agent declared or reached; None when they are not known."""
        return self.finds.found

    @property
    def declared(self) -> dict[tuple[int, int], Declared]:
        """By cell, the first who said so."""
        return self.finds.declared

    @property
    def ended(self) -> bool:
        """Every agent that was heard of has landed, failed or left the bus."""
        return bool(self.agents) and all(
            agent.alive is False or (agent.report is not None and agent.report.phase in _ENDED)
            for agent in self.agents.values()
        )

    def merged(self) -> tuple[F64, Bools] | None:
        """Probability and seen, (columns, rows), of the union of maps; None without a grid."""
        return self.maps.merged()

    def links(self) -> list[tuple[int, int]]:
        """Pairs (lower id first) of which one hears the other; none when the range is unknown."""
        hears = self._hearing()
        pairs = {(min(a, b), max(a, b)) for a, others in hears.items() for b in others}
        return sorted(pairs)

    def dropped(self) -> Counter[str]:
        """Frames that the radio did not deliver, by reason, over all agents."""
        return dropped(self._reports())

    def rejected(self) -> Counter[str]:
        """Frames that no honest agent sends, by reason."""
        return rejected(self._reports())

    def clocks(self) -> str:
        """How far clocks of other processes are off the launcher's, in words."""
        return apart(self._reports())

    def _reports(self) -> list[AgentReport]:
        return [agent.report for agent in self.agents.values() if agent.report is not None]

    def memberships(self) -> dict[int, Membership]:
        """By agent, what it belongs to by its own word; those that are in no group are left out."""
        if self.facts is None:
            return {}
        found = {}
        for agent in self.agents.values():
            payload = b"" if agent.frame is None else agent.frame.payload
            note = "" if agent.report is None else agent.report.note
            member = membership(self.facts.planner, agent.id, payload, note)
            if member is not None:
                found[agent.id] = member
        return found

    def heard_by(self) -> dict[int, list[int]]:
        """By sender, ascending, those whom its frames reach."""
        found: dict[int, list[int]] = {}
        for receiver, senders in self._hearing().items():
            for sender in senders:
                found.setdefault(sender, []).append(receiver)
        return dict(sorted(found.items()))

    def hears(self, agent: int) -> list[int]:
        """Those whose frames reach an agent, ascending."""
        return self._hearing().get(agent, [])

    def _hearing(self) -> dict[int, list[int]]:
        """By receiver, who is in radio range of it and sent something lately."""
        if self.facts is None:
            return {}
        return hearing(self.agents.values(), self.facts.radio.range_m, self.t_us)

    def _passed(self, t_us: int) -> bool:
        """Mission time is at least this; False when that cannot be."""
        if self.t_us >= 0 and t_us > self.t_us + LEAP_US:
            self.rejects["future"] += 1
            return False
        self._stale = self._stale + 1 if t_us < self.t_us - REWIND_US else 0
        before_s, self.t_us = self.t_us // SECOND_US, max(self.t_us, t_us)
        if self.t_us // SECOND_US > before_s:
            self._second()
        return True

    def _agent(self, number: int, t_us: int) -> Watched:
        agent = self.agents.get(number)
        if agent is None:
            agent = self.agents[number] = Watched(number)
        agent.seen_us = max(agent.seen_us, t_us)
        return agent

    def _second(self) -> None:
        """A second of mission time has begun: note where everybody is."""
        if self._joining:
            return
        t_s = to_s(self.t_us)
        flying: list[Vector] = []
        for agent in self.agents.values():
            if agent.position is None:
                continue
            agent.track.append((t_s, *agent.position))
            if agent.flying or agent.id in self.floor.driving:
                flying.append(agent.position)
        if not self.simulated:
            where = np.array(flying).reshape(-1, 3)
            self.separation.add(self.t_us, where, ground_m=-np.inf)
        if self._since_us is None:
            self._since_us = self.t_us
        # One who has just come knows the sums only when everybody has reported.
        everybody = all(agent.report for agent in self.agents.values())
        if everybody or to_s(self.t_us - self._since_us) > RECENT_S:
            self.series.append(self._point())

    def _point(self) -> Point:
        reports = [agent.report for agent in self.agents.values() if agent.report]
        return Point(
            self.t_us,
            *self.maps.scores(),
            len(self.finds.all()),
            self.found or 0,
            self.separation.take_recent(),
            sum(report.bytes_sent for report in reports),
            sum(report.bytes_heard for report in reports),
            sum(report.frames_sent for report in reports),
            sum(report.frames_heard for report in reports),
        )
