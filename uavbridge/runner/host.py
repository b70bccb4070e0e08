"""The agents of one process: feeds each its inputs, carries its effects out.

The stepped and the paced runner call the same ``step`` at every control tick;
only the bus, the links and the clock behind it differ.
"""

from __future__ import annotations

import logging
from base64 import b64encode
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from msgspec import UNSET, UnsetType

from planners.types import Answer as Told
from uavbridge.agent.agent import Agent
from uavbridge.agent.effects import Answer, Decided, Do, Effect, Inputs, Publish, Shine
from uavbridge.agent.orders import Order, Verb, encode_ack
from uavbridge.agent.orders import decode as decode_order
from uavbridge.agent.phases import ENDED
from uavbridge.agent.plan import AgentPlan
from uavbridge.agent.report import AgentReport, Clocks, encode
from uavbridge.agent.telling import whole_frame
from uavbridge.bus import keys
from uavbridge.bus.air import Air, SafetyBeacons
from uavbridge.bus.api import Bus, Mailbox, Sample
from uavbridge.bus.messages import FullMap, encode_map
from uavbridge.bus.wire import Vector, sender_and_tick
from uavbridge.bus.wire import encode as encode_frame
from uavbridge.clock import SECOND_US, to_s
from uavbridge.place.service import Service
from uavbridge.radio import Verdict
from uavbridge.recording.decisions import decision_record
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import (
    AnswerRecord,
    EventRecord,
    SetpointRecord,
    pack_heard,
)
from uavbridge.recording.topics import encode as encode_record
from uavbridge.report.result import Event
from uavbridge.runner.sensing import NOTHING, observed
from uavbridge.vehicle.api import SetVelocity, Vehicle, VehicleState

SETPOINT_RECORD_US = 500_000  # all of them are in the .tlog; these show what the filter left
MAP_US = 10 * SECOND_US  # between two whole maps for people
_ORDER = "order"
NEIGHBOUR_S = 3.0  # heard within this time counts as a neighbour, for people

_log = logging.getLogger(__name__)


@dataclass(slots=True, eq=False)
class Seat:
    """One agent with what belongs to it."""

    agent: Agent
    vehicle: Vehicle
    obs: Mailbox
    cmd: Mailbox
    map_us: int = 0  # when its map was last published for people


class HeardNotes:
    """What the radio did with each frame at each receiver, until it is recorded."""

    def __init__(self) -> None:
        self._rows: defaultdict[int, list[tuple[int, int, str]]] = defaultdict(list)
        self._data, self._frame = b"", (0, 0)  # the newest frame: most are noted many times over

    def note(self, receiver: int, data: bytes, delivered: bool, reason: str) -> None:
        """One frame at one receiver; the signature that ``Air`` logs with."""
        if data is not self._data:
            self._data, self._frame = data, sender_and_tick(data)
        self._rows[receiver].append((*self._frame, "delivered" if delivered else reason))

    def take(self) -> list[tuple[int, bytes]]:
        """(receiver, packed rows) since the last call, ascending receivers."""
        taken = [(receiver, pack_heard(self._rows[receiver])) for receiver in sorted(self._rows)]
        self._rows.clear()
        return taken


class AgentHost:
    """Runs agents over vehicles and a bus.

    Args:
        plans: of the agents of this process, ascending ids.
        vehicles: by agent id.
        bus: this process's session.
        air: the emulated radio.
        beacons: the separation beacon.
        recorder: None: nothing is recorded.
        heard: what the radio's log was given to, to be recorded.
        service: answers what planners ask; None: nobody does.
    """

    def __init__(
        self,
        plans: Sequence[AgentPlan],
        vehicles: Mapping[int, Vehicle],
        *,
        bus: Bus,
        air: Air,
        beacons: SafetyBeacons,
        recorder: Recorder | None = None,
        heard: HeardNotes | None = None,
        service: Service | None = None,
    ) -> None:
        self._service = service
        self._where: dict[int, Vector] = {}
        self._bus, self._air, self._beacons, self._recorder = bus, air, beacons, recorder
        self._everybody = bus.subscribe(keys.cmd())
        self._maps: dict[int, bytes] = {}
        self._heard = heard
        self.rejects: Counter[str] = Counter()  # malformed readings and orders
        self.events: list[Event] = []
        self.clocks: Clocks | UnsetType = UNSET  # how this machine's differ from the launcher's
        self._homewards = False
        self._t_us = 0
        self.seats = [self._seat(plan, vehicles[plan.agent]) for plan in plans]

    def _seat(self, plan: AgentPlan, vehicle: Vehicle) -> Seat:
        agent = plan.agent
        made = Agent(plan)
        self._bus.serve(keys.state_map(agent), lambda _key: self._maps.get(agent))
        self._bus.serve(
            keys.state_cells(agent),
            lambda _key: whole_frame(plan, made.mapping.belief, self._t_us),
        )
        self._bus.declare(keys.alive(agent))
        return Seat(
            made,
            vehicle,
            obs=self._bus.subscribe(keys.obs(agent)),
            cmd=self._bus.subscribe(keys.cmd(agent)),
        )

    @property
    def ended(self) -> bool:
        """Every agent has landed or failed."""
        return all(seat.agent.phase in ENDED for seat in self.seats)

    def call_home(self) -> None:
        """Have all agents of this process return and land."""
        self._homewards = True

    def step(self, t_us: int, *, late_s: float = 0.0) -> None:
        """One control tick of every agent, ascending ids.

        Args:
            t_us: mission time of the tick.
            late_s: how much later it really is.
        """
        self._t_us = t_us
        events = [seat.vehicle.advance(t_us) for seat in self.seats]
        states = [seat.vehicle.state for seat in self.seats]
        where = {
            seat.agent.plan.agent: _vector(state)
            for seat, state in zip(self.seats, states, strict=True)
        }
        self._where = where
        frames = self._air.receive(where, t_us)
        answers = self._service.receive(where, frames, t_us) if self._service else {}
        if self._recorder and self._heard:
            for receiver, rows in self._heard.take():
                self._recorder.write(f"heard/{receiver}", t_us, rows)
        beacons = self._beacons.receive(where, t_us)
        to_all = _orders(self._everybody.drain(), self.rejects)
        if self._homewards:
            to_all += (Order(Verb.RETURN),)
        for seat, state, happened in zip(self.seats, states, events, strict=True):
            agent = seat.agent.plan.agent
            looks = seat.obs.drain()
            seen = observed(looks, self.rejects) if looks else NOTHING
            if self._recorder:
                seen.write(self._recorder, agent, t_us)
            inputs = Inputs(
                t_us=t_us,
                state=state,
                events=happened,
                frames=tuple(frames.get(agent, ())),
                beacons=tuple(beacons.get(agent, ())),
                readings=seen.readings,
                signals=seen.signals,
                obstacles=tuple(one for _, one in seen.obstacles),
                answers=self._answered(agent, t_us, answers.get(agent, [])),
                orders=to_all + _orders(seat.cmd.drain(), self.rejects),
                late_s=late_s,
            )
            before = seat.agent.phase
            for effect in seat.agent.step(inputs):
                self._carry_out(seat, effect, t_us)
            if seat.agent.phase is not before:
                self._event(t_us, agent, "phase", seat.agent.phase.value)
            if t_us % SECOND_US == 0:
                self._report(seat, state, t_us)
        if self._service:
            self._service.step(t_us)

    def close(self) -> None:
        """Let go of the vehicles."""
        for seat in self.seats:
            seat.vehicle.close()

    def _answered(self, agent: int, t_us: int, answers: list[Told]) -> tuple[Told, ...]:
        if self._recorder:
            for one in answers:
                record = AnswerRecord(one.key, b64encode(one.data).decode(), one.age_s)
                self._recorder.record(f"answer/{agent}", t_us, record)
        return tuple(answers)

    def _carry_out(self, seat: Seat, effect: Effect, t_us: int) -> None:
        agent = seat.agent.plan.agent
        if isinstance(effect, Do):
            seat.vehicle.do(effect.command, t_us)
            if not self._recorder or t_us % SETPOINT_RECORD_US:
                return
            if isinstance(effect.command, SetVelocity):
                x, y, z = effect.command.velocity.tolist()
                record = SetpointRecord("velocity", [x, y, z])
                self._recorder.record(f"setpoint/{agent}", t_us, record)
        elif isinstance(effect, Publish):
            frame = self._service.outgoing(effect.frame) if self._service else effect.frame
            sent = self._air.send(frame)
            if sent and self._recorder:
                self._recorder.write(f"air/{agent}", t_us, sent)
            elif not sent and self._heard:
                self._heard.note(agent, encode_frame(frame), False, Verdict.QUEUE.reason)
        elif isinstance(effect, Shine):
            self._beacons.send(effect.beacon)
        elif isinstance(effect, Decided):
            if self._service:
                self._service.wish(agent, effect.goal, effect.tick, self._where[agent], t_us)
            if self._recorder:
                self._recorder.record(f"decision/{agent}", t_us, decision_record(effect))
        elif isinstance(effect, Answer):
            ack = effect.ack
            self._bus.publish(keys.ack(agent), encode_ack(ack))
            self._event(t_us, agent, "order", f"{ack.verb}: {ack.reason or 'done'}")
        else:
            self._event(t_us, agent, "failure" if effect.failure else "said", effect.text)

    def _event(self, t_us: int, agent: int, kind: str, text: str) -> None:
        _log.info("agent %d: %s", agent, text)  # the view and the summary tell failures
        self.events.append(Event(to_s(t_us), text, agent, kind))
        record = encode_record(EventRecord(kind, text, agent))
        self._bus.publish(keys.event(agent), record)
        if self._recorder:
            self._recorder.write("event", t_us, record)

    def _report(self, seat: Seat, state: VehicleState, t_us: int) -> None:
        """What people are told of one agent, once a second."""
        agent, number = seat.agent, seat.agent.plan.agent
        report = encode(self._said(seat, state, t_us))
        self._bus.publish(keys.state(number), report)
        grid, belief = agent.plan.scenario.grid, agent.mapping.belief
        self._maps[number] = encode_map(
            FullMap(
                number,
                t_us,
                grid.west_m,
                grid.south_m,
                grid.cell_m,
                belief.probability,
                belief.stamp_us,
            )
        )
        if t_us >= seat.map_us:
            seat.map_us = t_us + MAP_US
            self._bus.publish(keys.state_map(number), self._maps[number])
        if self._recorder:
            self._recorder.write(f"state/{number}", t_us, report)

    def _said(self, seat: Seat, state: VehicleState, t_us: int) -> AgentReport:
        agent, number = seat.agent, seat.agent.plan.agent
        rows = agent.plan.scenario.grid.rows
        radio, beacon = self._air.traffic[number], self._beacons.traffic[number]
        declared = agent.mapping.declared
        return AgentReport(
            agent=number,
            t_us=t_us,
            phase=agent.phase.value,
            mode=state.mode_text or state.mode.value,
            position=_vector(state),
            velocity=_vector_of(state.velocity.tolist()),
            heading=state.heading_rad,
            armed=state.armed,
            in_air=state.in_air,
            battery=state.battery if state.battery == state.battery else None,
            neighbours=agent.hearing.heard_within(t_us, NEIGHBOUR_S),
            note=agent.goal.note if agent.goal else "",
            distance_m=agent.flight.distance_m,
            declared=[(cell // rows, cell % rows, at) for cell, at in sorted(declared.items())],
            found=sorted(agent.found.items()),
            frames_sent=radio.frames_sent,
            frames_heard=radio.frames_heard,
            bytes_offered=radio.bytes_offered,
            bytes_sent=radio.bytes_sent,
            map_bytes_sent=radio.map_bytes_sent,
            bytes_heard=radio.bytes_heard,
            dropped=dict(sorted(radio.dropped.items())),
            dropped_bytes=dict(sorted(radio.dropped_bytes.items())),
            rejected=self._rejected(),
            beacon_bytes=beacon.bytes_sent + beacon.bytes_heard,
            failure=agent.flight.failure,
            clocks=self.clocks,
        )

    def _rejected(self) -> dict[str, int]:
        """What reached this process and could not be, by reason: frames, then the rest."""
        counts = dict(self._air.rejects)
        counts |= {f"beacon {why}": n for why, n in self._beacons.rejects.items()}
        for why, number in self.rejects.items():
            counts[why if why == _ORDER else f"reading {why}"] = number
        return dict(sorted(counts.items()))


def _orders(samples: list[Sample], rejects: Counter[str]) -> tuple[Order, ...]:
    if not samples:
        return ()
    orders = []
    for _, data in samples:
        try:
            orders.append(decode_order(data))
        except ValueError as fault:
            rejects[_ORDER] += 1
            _log.debug("malformed order dropped: %s: %r", fault, data[:80])
    return tuple(orders)


def _vector(state: VehicleState) -> Vector:
    return _vector_of(state.position.tolist())


def _vector_of(parts: list[float]) -> Vector:
    x, y, z = parts
    return x, y, z
