"""How an agent flies, or drives, its vehicle: readiness, start, search, home, landing.

``Flight.step`` gets what happened and the planner's newest setpoint, and returns
effects. Which velocities a phase wants is the ``Course``'s to say, by kind of
vehicle; the safety filter holds through all of it.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot

import numpy as np

from planners.types import Setpoint
from uavbridge.agent.course import Course
from uavbridge.agent.custody import OURS, Custody, Held, is_ours
from uavbridge.agent.driving import Driving
from uavbridge.agent.effects import Do, Effect, Inputs, Tell
from uavbridge.agent.flying import Flying
from uavbridge.agent.handling import HANDLING
from uavbridge.agent.net import net_of
from uavbridge.agent.obeying import Obeying
from uavbridge.agent.orders import Order, Verb
from uavbridge.agent.phases import DRIVEN, ENDED, FOLLOWING, Phase, check
from uavbridge.agent.plan import SIMULATED, AgentPlan
from uavbridge.agent.winging import Winging
from uavbridge.clock import to_s
from uavbridge.safety import winged
from uavbridge.safety.envelope import Envelope
from uavbridge.safety.filter import Traffic, Vector, constrain
from uavbridge.vehicle.api import (
    Arm,
    Command,
    Disarm,
    Done,
    Follow,
    HoldPosition,
    LandHere,
    Mode,
    Refused,
    ReturnHome,
    Said,
    SetNet,
    SetVelocity,
    TakeOff,
    VehicleEvent,
    VehicleState,
)

STOPPED_M_S = 0.2
SLOWEST = 0.7  # share of the speed limit below which a plane that we know nothing of is not flown
SLOWEST_CLIMB_M_S = 0.5  # of a vehicle that takes off
EARLY_S = 5.0  # called home so soon, a vehicle that is not there yet has not failed
EMPTY = 0.01  # share of a battery's charge
WARNING = 4  # MAV_SEVERITY; texts less severe stay with the vehicle
NEVER_US = -(1 << 60)


class Flight:
    """The phase machine of one vehicle."""

    def __init__(self, plan: AgentPlan) -> None:
        self.plan = plan
        self.phase = Phase.CONNECT
        self.course = _course(plan)
        self._way = plan.envelope  # on the way from home and back
        self._known = plan.envelope.columns  # before the mission
        self.distance_m = 0.0
        self.failure = ""
        self.limited_by: tuple[str, ...] = ()
        self._since_us = NEVER_US  # begin of the phase
        self._asked_us = NEVER_US  # newest command, repeated after plan.retry_s
        self._custody = Custody(simulated=plan.endpoint == SIMULATED)
        self._orders = Obeying(plan.agent)
        self._last: Vector | None = None
        self._refusal = ""
        self._net_set = plan.net is None
        self._granted = False  # what the phase asks for was done: take-off, landing
        self._returns = False  # an aircraft that can not land is left circling over home
        self._effects: list[Effect] = []
        self._pending: list[Effect] = []

    def step(
        self, inputs: Inputs, setpoint: Setpoint | None, traffic: list[Traffic]
    ) -> list[Effect]:
        """Effects of one control tick.

        Args:
            inputs: what reached the agent; frames and readings do not matter here.
            setpoint: the planner's newest, None before its first.
            traffic: the others by their separation beacons.
        """
        self._effects, self._pending = self._pending, []
        if self._since_us == NEVER_US:  # a mission may be joined late
            self._since_us = inputs.t_us
        self._odometer(inputs.state)
        self._orders.effects = self._effects
        self._learn_kind(inputs.state)
        self._custody.late(inputs.t_us, inputs.late_s)
        for event in inputs.events:
            self._happened(event, inputs)
        if self.phase not in ENDED:
            self._watch(inputs.state, inputs.t_us)
            for order in inputs.orders:
                self._obey(order, inputs.state, inputs.t_us)
            if to_s(inputs.t_us) >= self.plan.duration_s:
                self._end(inputs.state, inputs.t_us)
            self._fly(inputs.state, inputs.t_us, setpoint, traffic)
        return self._effects

    def _end(self, state: VehicleState, t_us: int) -> None:
        """The mission's time is over."""
        if self.plan.aloft and self.phase in (Phase.SEARCH, Phase.PAUSE):
            self._effects.append(Do(HoldPosition()))
            self._enter(Phase.ALOFT, t_us)
        else:
            self._obey(Order(Verb.RETURN), state, t_us)

    def keep_off(self, columns: tuple[tuple[float, float, float], ...]) -> None:
        """Stay out of columns that were seen, x, y and radius in m: all of them, each time."""
        envelope = replace(self.plan.envelope, columns=self._known + columns)
        self.plan = replace(self.plan, envelope=envelope)
        self._way = replace(self._way, columns=envelope.columns)

    def come_home(self, why: str, t_us: int) -> None:
        """Give up the search for a fault; the effect of it shows in the next ``step``."""
        self.failure = why
        self._pending.append(Tell(why, failure=True))
        if self.phase is Phase.SEARCH:
            self._enter(Phase.RISE, t_us)

    # What happened

    def _happened(self, event: VehicleEvent, inputs: Inputs) -> None:
        match event:
            case Said(severity, text):
                if severity <= WARNING:
                    self._tell(f"vehicle says: {text}")
            case Refused(SetNet(), reason) if self.phase is Phase.ARM:
                self._fail(reason, inputs.t_us)
            case Refused(Arm(), reason) if self.phase is Phase.ARM:
                self._refused(reason, "arming refused: ")
            case Refused(LandHere(), reason) if self._circles_to_land:
                self._refused(f"no landing: {reason}")
                self._returns = True
            case Refused(command, reason):
                self._refused(f"{type(command).__name__} refused: {reason}")
                self._orders.settle(command, reason, inputs.t_us)
            case Done(command):
                self._done(command, inputs)

    def _done(self, command: Command, inputs: Inputs) -> None:
        match command:
            case SetNet():
                self._net_set = True
            case TakeOff() if self.phase is Phase.TAKEOFF:
                self._granted = True
            case LandHere() if self.phase in (Phase.LAND, Phase.PARK):
                self._granted = True
            case Arm() if self.phase is Phase.ARM:
                self.course.home = _vector(inputs.state)
                self._way = self.plan.envelope.holding(self.course.home)
                self._enter(Phase.TAKEOFF, inputs.t_us)
            case Follow() if self.phase is Phase.TAKEOFF:
                self._enter(Phase.CLIMB, inputs.t_us)
            case Follow() if self.phase is Phase.START:
                self._enter(Phase.SEARCH, inputs.t_us)
            case Follow() if self.phase is Phase.YIELDED and self._orders.taking:
                self._orders.taking = False
                self.failure = ""
                self._enter(Phase.SEARCH, inputs.t_us)
        self._orders.settle(command, "", inputs.t_us)

    def _refused(self, reason: str, before: str = "") -> None:
        """Tell it, but once: what is refused is asked for again."""
        if reason != self._refusal:
            self._refusal = reason
            self._tell(f"{before}{reason}")

    def _watch(self, state: VehicleState, t_us: int) -> None:
        """Time-outs, silence, modes that nobody asked for."""
        if self.phase in (Phase.CONNECT, Phase.ARM):
            if to_s(t_us - self._since_us) > self.plan.ready_timeout_s:
                self._give_up(state, t_us)
        elif not state.link_ok and to_s(t_us - state.t_us) > self.plan.silence_s:
            self._fail(f"vehicle silent for {self.plan.silence_s:g} s", t_us)
        elif self.phase in (Phase.TAKEOFF, Phase.START):
            patience_s = self.plan.ready_timeout_s + self.plan.low_height_m / SLOWEST_CLIMB_M_S
            if to_s(t_us - self._since_us) > patience_s:
                self._come_down(state, t_us)
            else:
                self._watch_mode(state, t_us)
        elif self.phase in FOLLOWING and self._custody.stopped(state, t_us):
            self._fail_disarmed(state, t_us)
        elif self.phase in FOLLOWING and state.link_ok and not state.has_position:
            self.failure = "vehicle lost its position: it lands"
            self._tell(self.failure, failure=True)
            self._enter(Phase.LAND, t_us)
        elif self.phase is not Phase.YIELDED:
            self._watch_mode(state, t_us)

    def _come_down(self, state: VehicleState, t_us: int) -> None:
        """It does not take off, or follows no setpoints there."""
        mode = state.mode_text or state.mode.value
        what = "start" if self.plan.drives else "take-off"
        why = f"{what} failed: {self._refusal or f'vehicle is in {mode}'}"
        if self._under_way(state):
            self.failure = why
            self._tell(why, failure=True)
            self._enter(Phase.LAND, t_us)
        else:
            self._fail(why, t_us)

    def _watch_mode(self, state: VehicleState, t_us: int) -> None:
        held = self._custody.held(state.mode, self._is_ours(state), t_us)
        if held is Held.LET_GO:
            if self.phase in FOLLOWING:
                self._ask(Follow(), t_us)
            self._granted = False  # whatever else was asked for is asked for again
        elif held is Held.BY_SOMEBODY:
            self.failure = f"vehicle went to {state.mode_text or state.mode.value}: yielded"
            self._tell(self.failure, failure=True)
            self._enter(Phase.YIELDED, t_us)

    def _is_ours(self, state: VehicleState) -> bool:
        granted = self._granted and self._under_way(state) and state.armed
        circles, high = self.course.handling.circles, self._is_high(state)
        return is_ours(self.phase, state.mode, granted=granted, high=high, circles=circles)

    def _give_up(self, state: VehicleState, t_us: int) -> None:
        """It is time to fly, or to end, and the vehicle is not ready."""
        waited_s = to_s(t_us - self._since_us)
        if self.phase is Phase.ARM:
            why = self._refusal or ", ".join(state.waiting_for) or "no answer"
            self._fail(f"refused to arm: {why}", t_us)
        else:
            missing = "no position" if state.link_ok else "never answered: no heartbeat"
            self._fail(f"{missing} in {waited_s:.0f} s ({self.plan.endpoint})", t_us)

    def _obey(self, order: Order, state: VehicleState, t_us: int) -> None:
        if self.phase in (Phase.CONNECT, Phase.ARM):
            refusal = self._obey_on_the_ground(order, state, t_us)
        else:
            refusal = self._obey_on_the_way(order, state, t_us)
        self._orders.answer(order, refusal, t_us)

    def _obey_on_the_ground(self, order: Order, state: VehicleState, t_us: int) -> str:
        if order.verb not in (Verb.RETURN, Verb.LAND, Verb.ABORT):
            return f"not in phase {self.phase.value}"
        ready = self.phase is Phase.ARM and not self._refusal
        if ready or to_s(t_us - self._since_us) < EARLY_S:
            self._enter(Phase.DONE, t_us)
        else:
            self._give_up(state, t_us)
        return ""

    def _obey_on_the_way(self, order: Order, state: VehicleState, t_us: int) -> str:
        """Why the order can not be followed now; nothing when it is."""
        after = self._orders.phase_after(order, self.phase)
        if after is None:
            return f"not in phase {self.phase.value}"
        if order.verb in (Verb.PAUSE, Verb.GOTO):
            x, y, z = order.position or _vector(state)
            self.course.stay((x, y, z if z == z else _vector(state)[2]))
        if self.phase is not after:
            self._enter(after, t_us)
        return ""

    # Under way

    def _fly(
        self, state: VehicleState, t_us: int, setpoint: Setpoint | None, traffic: list[Traffic]
    ) -> None:
        position = _vector(state)
        if self.phase is Phase.CONNECT:
            self._meet(state, t_us)
        elif self.phase is Phase.ARM:
            if not self._net_set:
                self._ask(SetNet(net_of(self.plan, position, self._take_off_m)), t_us)
            elif not state.waiting_for:
                self._ask(Arm(), t_us)
        elif self.phase is Phase.TAKEOFF:
            self._take_off(state, t_us)
        elif self.phase is Phase.START:
            self._set_out(t_us)
        elif self.phase is Phase.LAND:
            self._land(state, t_us)
        elif self.phase is Phase.PARK:
            self._park(state, t_us)
        elif self.phase is Phase.YIELDED:
            self._leave_alone(state, t_us)
        elif self.phase in FOLLOWING:
            self._follow(state, t_us, setpoint, traffic)

    def _meet(self, state: VehicleState, t_us: int) -> None:
        """The vehicle is there; one that flies already is ours only if we flew it before."""
        if not (state.link_ok and state.has_position):
            return
        if not (state.armed and state.in_air):
            self._enter(Phase.ARM, t_us)
            return
        x, y, _ = self.plan.start
        ground = 0.0 if self.plan.terrain is None else float(self.plan.terrain.height_at((x, y)))
        self.course.home = self.plan.home or (x, y, ground)
        self._way = self.plan.envelope.holding(self.course.home)
        ours = self.plan.resumes or self.plan.aloft
        self._orders.taking = ours and state.mode in OURS
        mode = state.mode_text or state.mode.value
        if self._orders.taking and not self.plan.aloft:
            self._tell(f"takes over its vehicle in {mode}")
        elif not self._orders.taking:
            self.failure = f"vehicle is in the air already, in {mode}: yielded"
            self._tell(self.failure, failure=True)
        self._enter(Phase.YIELDED, t_us)

    @property
    def _take_off_m(self) -> float:
        return max(self.plan.low_height_m, self.course.handling.take_off_m)

    def _is_high(self, state: VehicleState) -> bool:
        above_m = float(state.position[2]) - self.course.home[2]
        return above_m >= 0.8 * self._take_off_m

    def _take_off(self, state: VehicleState, t_us: int) -> None:
        if not self._is_ours(state):
            return
        if self._is_high(state):
            self._set_out(t_us)
        elif state.mode is not Mode.TAKEOFF and not (self._granted and state.mode is Mode.OFFBOARD):
            self._ask(TakeOff(self._take_off_m), t_us)

    def _set_out(self, t_us: int) -> None:
        self._stop()
        self._ask(Follow(), t_us)

    def _park(self, state: VehicleState, t_us: int) -> None:
        if not state.armed:
            self._enter(Phase.DONE, t_us)
            return
        if state.mode is Mode.OFFBOARD:
            self._stop()
        if hypot(*state.velocity.tolist()) < STOPPED_M_S:
            # PX4's rovers are "in the air" when armed, but in its mode for landing.
            self._ask(LandHere() if state.in_air else Disarm(), t_us)

    @property
    def _circles_to_land(self) -> bool:
        return self.phase is Phase.LAND and self.course.handling.circles

    def _land(self, state: VehicleState, t_us: int) -> None:
        if not state.armed and not state.in_air:
            self._enter(Phase.DONE, t_us)
        elif self._returns and state.mode is Mode.RETURN:
            self._tell("circles over home by its autopilot, which is to land it")
            self._enter(Phase.DONE, t_us)
        elif self._returns:
            self._ask(ReturnHome(), t_us)
        elif state.mode is not Mode.LAND and not self._granted:
            self._ask(LandHere(), t_us)

    def _leave_alone(self, state: VehicleState, t_us: int) -> None:
        """The vehicle is not ours, but for what an order says."""
        if not state.armed and state.battery < EMPTY:
            self._fail_disarmed(state, t_us)
        elif not state.armed and not state.in_air:
            self._enter(Phase.DONE, t_us)
        elif self._orders.handing:
            self._orders.handing = state.mode is not Mode.HOLD
            if self._orders.handing:
                self._ask(HoldPosition(), t_us)
        elif self._orders.taking:
            self._set_out(t_us)

    def _follow(
        self, state: VehicleState, t_us: int, setpoint: Setpoint | None, traffic: list[Traffic]
    ) -> None:
        position = _vector(state)
        vx, vy, vz = state.velocity.tolist()
        leg = self.course.steer(self.phase, position, t_us, setpoint, traffic)
        if leg.after is not None:
            self._arrive(leg.after, t_us)
        near_ground = self.phase in (Phase.CLIMB, Phase.DESCEND, Phase.LAND)
        envelope = self._envelope()
        safe = (winged.constrain if envelope.slowest_m_s > 0.0 else constrain)(
            leg.velocity,
            position,
            (vx, vy, vz),
            traffic,
            envelope,
            keep_band=not near_ground,
        )
        self.limited_by = safe.limited_by
        self._effects.append(Do(SetVelocity(np.array(safe.velocity))))

    def _envelope(self) -> Envelope:
        searches = self.phase is Phase.SEARCH or self.phase is Phase.PAUSE
        return self.plan.envelope if searches else self._way

    def _learn_kind(self, state: VehicleState) -> None:
        """The vehicle itself says what it is, and gets the course of those."""
        handling = HANDLING[state.kind]
        if self.phase is Phase.CONNECT:
            before = envelope = self.plan.envelope
            if not (handling.flies or self.plan.drives):
                envelope = replace(envelope, drives=True)
            elif handling.circles and not envelope.slowest_m_s:
                envelope = replace(envelope, slowest_m_s=SLOWEST * envelope.speed_m_s)
            if envelope is not before:
                self.plan = replace(self.plan, drives=envelope.drives, envelope=envelope)
                self.course, self._way = _course(self.plan), envelope
        self.course.handling = handling

    def _arrive(self, phase: Phase, t_us: int) -> None:
        if self.course.trouble and not self.failure:
            self.failure = self.course.trouble
            self._tell(self.failure, failure=True)
        self._enter(phase, t_us)

    # Small things

    def _enter(self, phase: Phase, t_us: int) -> None:
        if self.plan.drives:
            phase = DRIVEN.get(phase, phase)
        self.phase = check(self.phase, phase)
        self._since_us = t_us
        self._asked_us = NEVER_US
        self._custody.begin()
        self._granted = False

    def _ask(self, command: Command, t_us: int) -> None:
        """Give a command, again every ``retry_s`` until the phase changes."""
        if to_s(t_us - self._asked_us) >= self.plan.retry_s:
            self._asked_us = t_us
            self._effects.append(Do(command))

    def _stop(self) -> None:
        self._effects.append(Do(SetVelocity(np.zeros(3))))

    def _under_way(self, state: VehicleState) -> bool:
        return state.in_air or (self.plan.drives and state.armed)

    def _tell(self, text: str, failure: bool = False) -> None:
        self._effects.append(Tell(text, failure))

    def _fail(self, why: str, t_us: int) -> None:
        self.failure = why
        self._tell(why, failure=True)
        self._enter(Phase.FAILED, t_us)

    def _fail_disarmed(self, state: VehicleState, t_us: int) -> None:
        charge = ", its battery is empty" if state.battery < EMPTY else ""
        self._fail(f"vehicle disarmed in phase {self.phase.value}{charge}", t_us)

    def _odometer(self, state: VehicleState) -> None:
        here = _vector(state)
        if self._under_way(state) and self._last is not None:
            last = self._last
            self.distance_m += hypot(here[0] - last[0], here[1] - last[1], here[2] - last[2])
        self._last = here if state.has_position else None


def _course(plan: AgentPlan) -> Course:
    if plan.drives:
        return Driving(plan)
    return Winging(plan) if plan.envelope.slowest_m_s > 0.0 else Flying(plan)


def _vector(state: VehicleState) -> Vector:
    x, y, z = state.position.tolist()
    return x, y, z
