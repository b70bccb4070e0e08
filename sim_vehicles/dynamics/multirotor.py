"""Multirotors: six degrees of freedom under cascaded control, all at once."""

from __future__ import annotations

import numpy as np

from planners.terrain import Terrain
from sim_vehicles.dynamics.airframe import GRAVITY, MultirotorParams
from sim_vehicles.dynamics.attitude import Attitude
from sim_vehicles.dynamics.battery import Battery
from sim_vehicles.dynamics.cascade import Cascade
from sim_vehicles.dynamics.demand import Demand
from sim_vehicles.dynamics.model import F64, Setpoints, States

_DEFAULT = MultirotorParams()
_UNSTICK = 0.05  # m/s2 of lift above weight that takes a vehicle off the ground


class Multirotor:
    """Multirotors with attitude and motor lag, drag, ground and battery.

    Position and velocity loops give the thrust vector wanted (``Cascade``), the
    attitude follows (``Attitude``), thrust follows with the motors' lag, and the
    body moves under thrust, gravity and drag relative to the wind. Motors off, or
    an empty battery, and it falls. On the ground it stays while thrust is under
    weight.

    Arrays are kept in columns, a component a row, and work space is kept between
    steps: the cost of a step is some 150 numpy calls, hardly more for a hundred
    vehicles than for one. States may be moved by writing into them in place.
    """

    def __init__(
        self,
        position: F64,
        yaw: F64,
        *,
        params: MultirotorParams = _DEFAULT,
        ground_m: float = 0.0,
        terrain: Terrain | None = None,
    ) -> None:
        """Place vehicles at rest: on the ground, or hovering where above it.

        Args:
            position: (n, 3) ENU m. A vehicle that starts under ``ground_m`` has its
                ground there.
            yaw: (n,) rad.
            params: the airframe, the same for all.
            ground_m: height of the ground where there is no terrain.
            terrain: heights of the ground.
        """
        n = len(position)
        self._params = params
        self._position: F64 = np.array(np.asarray(position, dtype=np.float64).T, order="C")
        self._velocity: F64 = np.zeros((3, n))
        rates, angles = np.zeros((3, n)), np.zeros((2, n))
        states = States.at(self._position.T, yaw)
        states.position, states.velocity = self._position.T, self._velocity.T
        states.rates, states.roll, states.pitch = rates.T, angles[0], angles[1]
        self._states = states

        self._terrain = terrain
        self._ground: F64 = states.ground
        self._ground[:] = np.minimum(self._position[2], ground_m)
        if terrain is not None:
            self._ground[:] = terrain.height_at(states.position)
        states.on_ground[:] = self._position[2] <= self._ground
        self._lift = np.where(states.on_ground, 0.0, GRAVITY)  # thrust per mass, m/s2
        states.thrust[:] = self._lift / (params.thrust_to_weight * GRAVITY)

        self._demand = Demand(n)
        self._cascade = Cascade(n, params)
        self._attitude = Attitude(states, rates, angles, params)
        self._battery = Battery(states, params.battery)
        self._off = np.zeros(n, dtype=np.bool_)
        self._idle = np.zeros(n, dtype=np.bool_)
        self._acceleration = np.zeros((3, n))
        self._vector = np.zeros((3, n))
        self._row = np.zeros(n)

    @property
    def states(self) -> States:
        return self._states

    def step(self, setpoints: Setpoints, wind: F64, dt_s: float) -> None:
        self._demand.gather(setpoints, self._position, self._states.yaw)
        some_idle = self._find_idle(setpoints)
        force = self._cascade.force(self._demand, setpoints, self._velocity, dt_s)
        if some_idle:
            np.copyto(force[:2], 0.0, where=self._idle)
            np.copyto(self._demand.turn, 0.0, where=self._idle)
            np.copyto(self._demand.turn_rate, 0.0, where=self._idle)
        self._attitude.step(force[:2], self._demand, dt_s)
        self._spin(force[2], some_idle, dt_s)
        self._push(wind, some_idle)
        self._move(dt_s)

    def _find_idle(self, setpoints: Setpoints) -> bool:
        """Find who stands or has no power; their loops start anew."""
        off, idle, on_ground = self._off, self._idle, self._states.on_ground
        self._battery.alive(off)
        np.logical_and(off, setpoints.motors, out=off)
        np.logical_not(off, out=off)
        np.logical_or(off, on_ground, out=idle)
        if not idle.any():
            return False
        self._cascade.rest(idle, self._velocity)
        self._attitude.rest(on_ground)
        return True

    def _spin(self, lift: F64, some_idle: bool, dt_s: float) -> None:
        """Motors follow the ``lift`` wanted (n,) m/s2, whatever the tilt."""
        p, thrust, row = self._params, self._lift, self._row
        most = p.thrust_to_weight * GRAVITY
        lift *= self._attitude.stretch
        np.maximum(lift, p.idle_thrust * most, out=lift)
        np.minimum(lift, most, out=lift)
        if some_idle:
            np.copyto(lift, 0.0, where=self._off)
            np.add(thrust, dt_s / p.spool_s * most, out=row)
        lift -= thrust
        lift *= -np.expm1(-dt_s / p.motor_lag_s)
        thrust += lift
        if some_idle:
            np.minimum(thrust, row, out=thrust, where=self._states.on_ground)
        np.multiply(thrust, 1.0 / most, out=self._states.thrust)
        np.multiply(thrust, 1.0 / GRAVITY, out=row)
        self._battery.draw(row, dt_s)

    def _push(self, wind: F64, some_idle: bool) -> None:
        """Acceleration by thrust, gravity and drag; none where the ground holds."""
        p, row, push, air = self._params, self._row, self._acceleration, self._vector
        np.subtract(self._velocity, wind.T, out=air)
        np.multiply(air, air, out=push)
        np.add.reduce(push, axis=0, out=row)
        np.sqrt(row, out=row)
        row *= p.drag_quadratic_1_m
        row += p.drag_linear_1_s
        air *= row
        np.divide(self._lift, self._attitude.stretch, out=push[2])
        np.multiply(self._attitude.tilt, push[2], out=push[:2])
        push -= air
        push[2] -= GRAVITY
        if some_idle:
            held = np.less(push[2], _UNSTICK, out=self._idle)
            np.logical_and(held, self._states.on_ground, out=held)
            np.copyto(push, 0.0, where=held)

    def _move(self, dt_s: float) -> None:
        position, velocity, change = self._position, self._velocity, self._vector
        np.multiply(velocity, dt_s, out=change)
        position += change
        np.multiply(self._acceleration, dt_s, out=change)
        velocity += change
        change *= 0.5 * dt_s
        position += change
        if self._terrain is not None:
            self._ground[:] = self._terrain.height_at(self._states.position)
        on_ground = np.less_equal(position[2], self._ground, out=self._states.on_ground)
        if on_ground.any():
            np.copyto(position[2], self._ground, where=on_ground)
            np.copyto(velocity, 0.0, where=on_ground)
