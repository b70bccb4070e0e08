"""The frame that an agent sends."""

from __future__ import annotations

import logging

import numpy as np

from planners.belief.maps import BeliefMap
from uavbridge.agent.mapping import Mapping
from uavbridge.agent.plan import AgentPlan
from uavbridge.bus.wire import CELLS_LIMIT, DELTA, KEYFRAME, Frame, Vector, encode, head_bytes
from uavbridge.clock import to_us

_log = logging.getLogger(__name__)


class Telling:
    """Makes an agent's frames, one after the other, within the mission's budget of bytes.

    The position and the planner's payload always go; what is left is for the map.

    Args:
        plan: the agent's.
        mapping: its map.
    """

    def __init__(self, plan: AgentPlan, mapping: Mapping) -> None:
        self._plan, self._mapping = plan, mapping
        self._tick_us = to_us(plan.scenario.tick_s)
        self._head_bytes = head_bytes(self._tick_us)
        self._next_whole_s = plan.keyframe_s
        self._warned = False

    def frame(self, t_us: int, position: Vector, velocity: Vector, payload: bytes) -> Frame:
        """The frame for one time; call it once a frame.

        Args:
            t_us: now.
            position: ENU m.
            velocity: m/s.
            payload: the planner's.
        """
        plan, tick = self._plan, t_us // self._tick_us
        whole = t_us >= self._next_whole_s * 1e6
        if whole:
            self._next_whole_s += plan.keyframe_s
        room = max(0.0, plan.frame_bytes - self._head_bytes - len(payload))
        if room < plan.rule.record.itemsize and not self._warned:
            self._warned = True
            _log.warning(
                "agent %d: a payload of %d bytes leaves no room for the map in radio.frame_bytes",
                plan.agent,
                len(payload),
            )
        told = self._mapping.tell(tick, room, whole=whole)
        return Frame(
            kind=KEYFRAME if told.whole else DELTA,
            sender=plan.agent,
            tick=tick,
            t_us=t_us,
            position=position,
            velocity=velocity,
            payload=payload,
            rule=plan.rule.code,
            cells=told.cells,
            mission=plan.mission_mark,
            root=told.root,
            heard=told.heard,
            probes=told.probes,
        )


def whole_frame(plan: AgentPlan, belief: BeliefMap, t_us: int) -> bytes | None:
    """All that an agent knows of the map, for onlookers; None: more than a frame holds.

    Safe on another thread than the agent's: maps are replaced, never changed.
    """
    cells = plan.rule.records(belief, np.flatnonzero(belief.seen.reshape(-1))).tobytes()
    if len(cells) > CELLS_LIMIT:
        return None
    nowhere = (0.0, 0.0, 0.0)
    return encode(
        Frame(
            KEYFRAME,
            plan.agent,
            t_us // to_us(plan.scenario.tick_s),
            t_us,
            nowhere,
            nowhere,
            rule=plan.rule.code,
            cells=cells,
            mission=plan.mission_mark,
        )
    )
