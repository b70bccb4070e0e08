"""A team that maps and tells, over a radio that a test may do anything to."""

from collections import defaultdict

import numpy as np

from planners.belief.merge import MERGE_RULES, SensorModel
from planners.grid import Grid
from planners.types import Reading, Scenario
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.plan import AgentPlan
from uavbridge.agent.telling import Telling
from uavbridge.bus.wire import decode, encode
from uavbridge.safety.envelope import Envelope

SECOND = 1_000_000
ZERO = (0.0, 0.0, 0.0)


def plan_of(agent, merge, grid, frame_bytes=np.inf, keyframe_s=np.inf, team=(1, 2, 3)):
    """An agent's plan without a planner."""
    return AgentPlan(
        agent=agent,
        seed=1,
        scenario=Scenario(grid, team, np.zeros((len(team), 3)), tick_s=1.0),
        planner=None,
        rule=MERGE_RULES[merge],
        sensor=SensorModel(0.9, 0.2),
        prior=np.full(grid.shape, 0.5),
        envelope=Envelope(0, 0, 400, 400, 15, 100),
        start=ZERO,
        return_height_m=20.0,
        duration_s=100.0,
        frame_bytes=frame_bytes,
        keyframe_s=keyframe_s,
    )


class Swarm:
    """Agents 0 to n - 1 that speak once a tick.

    Attributes:
        tick: now.
        bytes_sent: by all together.
        map_bytes_sent: of these, for cells and probes.
    """

    def __init__(self, count, merge, grid=None, frame_bytes=np.inf, keyframe_s=np.inf):
        self.grid = grid or Grid(0, 0, 100, 6, 6)
        self.tick = 0
        self.bytes_sent = self.map_bytes_sent = 0
        team = tuple(range(count))
        self.plans = [plan_of(i, merge, self.grid, frame_bytes, keyframe_s, team) for i in team]
        self.minds = [self._fresh(plan) for plan in self.plans]
        self._due = defaultdict(list)  # tick -> (receiver, frame)

    @staticmethod
    def _fresh(plan):
        mapping = Mapping(plan)
        return mapping, Telling(plan, mapping)

    def restart(self, agent):
        """It forgets everything."""
        self.minds[agent] = self._fresh(self.plans[agent])

    def observe(self, agent, cell, detected):
        """One look."""
        column, row = divmod(int(cell) % self.grid.size, self.grid.rows)
        at = self.tick * SECOND + agent
        self.minds[agent][0].observe(Reading(at, (column, row), bool(detected)))

    def exchange(self, fate):
        """One tick: all hear what is due, then all tell.

        Args:
            fate: of (sender, receiver): in how many ticks the frame arrives, once each.
        """
        inboxes = defaultdict(list)
        for receiver, frame in self._due.pop(self.tick, ()):
            inboxes[receiver].append(frame)
        for receiver, frames in inboxes.items():
            self.minds[receiver][0].merge(frames)
        for sender, (_, telling) in enumerate(self.minds):
            frame = telling.frame(self.tick * SECOND, ZERO, ZERO, b"")
            data = encode(frame)
            self.bytes_sent += len(data)
            self.map_bytes_sent += frame.map_bytes
            assert len(data) <= self.plans[sender].frame_bytes
            heard = decode(data)
            for receiver in range(len(self.minds)):
                if receiver != sender:
                    for delay in fate(sender, receiver):
                        self._due[self.tick + delay].append((receiver, heard))
        self.tick += 1

    def alike(self, values=True):
        """Whether all maps agree cell by cell."""
        first, *others = (mapping.belief for mapping, _ in self.minds)
        return all(
            np.array_equal(first.stamp_us, other.stamp_us)
            and (not values or np.array_equal(first.probability, other.probability))
            and (not values or np.array_equal(first.origin, other.origin))
            for other in others
        )

    def settle(self, linked, most, values=True):
        """Ticks over good links until all maps agree; None: they do not within ``most``."""
        for tick in range(most):
            if self.alike(values):
                return tick
            self.exchange(lambda a, b: (1,) if linked(a, b) else ())
        return None
