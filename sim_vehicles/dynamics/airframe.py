"""Parameters of a multirotor: airframe, limits, loops, battery."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

GRAVITY = 9.80665  # m/s2, ISO 80000-3


@dataclass(frozen=True, slots=True)
class BatteryParams:
    """A four-cell pack that hovers a multirotor for about twenty minutes."""

    capacity_ah: float = 5.2
    hover_a: float = 15.0  # motors, at thrust = weight; grows with thrust ** 1.5
    avionics_a: float = 0.6  # always drawn
    full_v: float = 16.8  # at rest
    empty_v: float = 14.0  # at rest
    resistance_ohm: float = 0.03

    def __post_init__(self) -> None:
        _require_sense(self)


@dataclass(frozen=True, slots=True)
class MultirotorParams:
    """A camera-drone sized multirotor under a common autopilot.

    Limits and gains lie between the defaults of ArduCopter 4.6 and PX4 1.17;
    docs/reference/vehicle_model.md compares the step responses.
    """

    speed_m_s: float = 12.0  # horizontal, over ground
    climb_m_s: float = 3.0
    sink_m_s: float = 1.5
    acceleration_m_s2: float = 2.4  # horizontal change of the velocity reference
    braking_m_s2: float = 2.7  # what the approach to a position plans with
    lift_m_s2: float = 2.0  # vertical change of the velocity reference
    levelling_m_s2: float = 2.0  # vertical braking planned with
    tilt_rad: float = 0.7
    yaw_rate_rad_s: float = 1.75
    yaw_acceleration_rad_s2: float = 3.5

    position_gain_1_s: float = 1.2
    shaping_s: float = 0.5  # lag of the velocity reference
    velocity_gain_1_s: float = 2.0
    velocity_integral_1_s2: float = 2.0
    lift_gain_1_s: float = 4.0
    lift_integral_1_s2: float = 1.5
    attitude_rad_s: float = 8.0  # critically damped: gain 4 1/s over a rate lag of 0.06 s
    yaw_gain_1_s: float = 3.5
    yaw_lag_s: float = 0.1

    thrust_to_weight: float = 2.0
    idle_thrust: float = 0.05  # share of the largest, while the motors spin
    motor_lag_s: float = 0.05
    spool_s: float = 3.0  # from idle to full thrust while on the ground
    drag_linear_1_s: float = 0.33  # rotors: per mass, per m/s of air speed
    drag_quadratic_1_m: float = 0.008  # body: per mass
    battery: BatteryParams = field(default_factory=BatteryParams)

    def __post_init__(self) -> None:
        _require_sense(self)
        if self.thrust_to_weight <= 1.0:
            raise ValueError(f"thrust_to_weight must be above 1: {self.thrust_to_weight}")
        if self.tilt_rad > 1.2:
            raise ValueError(f"tilt_rad must be at most 1.2: {self.tilt_rad}")


_MAY_BE_ZERO = (
    *("hover_a", "avionics_a", "resistance_ohm", "idle_thrust"),
    *("velocity_integral_1_s2", "lift_integral_1_s2", "drag_linear_1_s", "drag_quadratic_1_m"),
)


def _require_sense(params: BatteryParams | MultirotorParams) -> None:
    for each in fields(params):
        value = getattr(params, each.name)
        if isinstance(value, BatteryParams):
            continue
        if not 0.0 <= value < float("inf"):
            raise ValueError(f"{each.name} must be finite and not negative: {value}")
        if value == 0.0 and each.name not in _MAY_BE_ZERO:
            raise ValueError(f"{each.name} must be positive: {value}")
