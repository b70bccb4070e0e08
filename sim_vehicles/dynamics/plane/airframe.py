"""The Aerosonde: mass, aerodynamics, propeller, battery, and what its autopilot allows.

Beard and McLain, "Small Unmanned Aircraft: Theory and Practice", first edition 2012,
Appendix E, Table E.2. Later editions and the book's supplements have other masses (11 and 25 kg)
and another propeller. With these numbers the aircraft stalls at 15 m/s and full throttle sustains
75 m/s in level flight; level trim at 35 m/s is an angle of attack of 0.003 rad at a
throttle of 0.46.

The book's aircraft burns fuel. Ours has a battery (ours: 2.4 kWh) that gives the power which the
propeller puts into its stream.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians

import numpy as np

from sim_vehicles.dynamics.model import F64


@dataclass(frozen=True, slots=True)
class Pack:
    """A twelve-cell battery and its motor."""

    energy_j: float = 2.4 * 3.6e6
    avionics_w: float = 15.0
    efficiency: float = 0.8  # of motor and controller
    full_v: float = 50.4
    empty_v: float = 42.0
    resistance_ohm: float = 0.03


@dataclass(frozen=True, slots=True)
class PlaneLimits:
    """What the autopilot asks of the aircraft at most."""

    slowest_m_s: float = 20.0  # airspeed
    trim_m_s: float = 35.0
    fastest_m_s: float = 70.0
    bank_rad: float = radians(55.0)
    climb_rad: float = 0.45  # of the flight path
    sink_rad: float = 0.40
    attack_rad: float = 0.30  # angle of attack; it stalls at 0.47
    faster_m_s2: float = 5.0
    slower_m_s2: float = 4.0
    radius_m: float = 80.0  # of a loiter when none is asked for; grows with speed
    rotate_m_s: float = 20.0  # the nose is lifted on the runway


@dataclass(frozen=True, slots=True)
class PlaneParams:
    """Coefficients in the book's notation: SI, angles in rad, body axes forward, right, down."""

    mass: float = 13.5
    jx: float = 0.8244
    jy: float = 1.135
    jz: float = 1.759
    jxz: float = 0.1204
    area: float = 0.55
    span: float = 2.8956
    chord: float = 0.18994
    air: float = 1.2682  # kg/m3
    oswald: float = 0.9
    prop_area: float = 0.2027
    prop_c: float = 1.0
    motor_k: float = 80.0  # m/s of the stream behind the propeller, at full throttle
    stall_m: float = 50.0
    stall_rad: float = 0.4712

    lift_0: float = 0.28
    lift_a: float = 3.45
    lift_e: float = -0.36
    drag_p: float = 0.0437
    pitch_0: float = -0.02338
    pitch_a: float = -0.38
    pitch_q: float = -3.6
    pitch_e: float = -0.5
    side_b: float = -0.98
    side_r: float = -0.17  # of the rudder
    roll_b: float = -0.12
    roll_p: float = -0.26
    roll_r: float = 0.14
    roll_aileron: float = 0.08
    roll_rudder: float = 0.105
    yaw_b: float = 0.25
    yaw_p: float = 0.022
    yaw_r: float = -0.35
    yaw_aileron: float = 0.06
    yaw_rudder: float = -0.032

    deflection_rad: float = radians(25.0)  # of any surface, at most
    limits: PlaneLimits = field(default_factory=PlaneLimits)
    pack: Pack = field(default_factory=Pack)

    @property
    def induced(self) -> float:
        """Drag coefficient per squared lift coefficient."""
        return float(self.area / (np.pi * self.oswald * self.span**2))

    def thrust(self, throttle: F64, airspeed: F64) -> F64:
        """Thrust (n,) N of the propeller; negative where the stream is slower than the air."""
        disc = 0.5 * self.air * self.prop_area * self.prop_c
        return np.asarray(disc * ((self.motor_k * throttle) ** 2 - airspeed**2))

    def throttle(self, thrust: F64, airspeed: F64) -> F64:
        """Throttle (n,) 0..1 that gives a thrust, or as near to it as there is."""
        disc = 0.5 * self.air * self.prop_area * self.prop_c
        stream = np.sqrt(np.maximum(thrust / disc + airspeed**2, 0.0))
        return np.asarray(np.minimum(stream / self.motor_k, 1.0))

    def trim(self, airspeed: F64, load: F64, pitch_rate: F64) -> tuple[F64, F64, F64]:
        """Angle of attack, elevator and drag (n,) that hold a lift of ``load`` (n,) m/s2.

        Linear aerodynamics: exact below the stall. The angle of attack is not bounded.
        """
        pressure = 0.5 * self.air * airspeed**2 * self.area
        lift = self.mass * load / pressure
        damping = self.pitch_0 + self.pitch_q * pitch_rate * self.chord / (2.0 * airspeed)
        per_e = self.lift_e / self.pitch_e
        attack = (lift - self.lift_0 + per_e * damping) / (self.lift_a - per_e * self.pitch_a)
        elevator = -(damping + self.pitch_a * attack) / self.pitch_e
        wing = self.lift_0 + self.lift_a * attack
        return attack, elevator, pressure * (self.drag_p + self.induced * wing**2)
