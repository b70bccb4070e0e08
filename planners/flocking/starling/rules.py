"""The constants of a starling flock.

Chen, Tang, Li, Wang and Hu 2023, "A Study of Collaborative Trajectory Planning Method Based on
Starling Swarm Bionic Algorithm for Multi-Unmanned Aerial Vehicle", Appl. Sci. 13, 6795.

The paper prints the distances and the desired speed; every gain is ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from planners.planner import param


@dataclass(frozen=True, slots=True)
class StarlingRules:
    """Distances and gains of one aircraft; the same for all."""

    perception_m: float = param(260.0, unit="m", doc="R_p: how far others are seen", low=1.0)
    neighbours: int = param(7, unit="1", doc="nearest visible neighbours that count", low=1)
    near_m: float = param(35.0, unit="m", doc="R_minl: nearer to their centre: dispersal", low=0.0)
    far_m: float = param(70.0, unit="m", doc="R_maxl: farther from their centre: gathering", low=0)
    repel_m: float = param(30.0, unit="m", doc="R_e: nearer to one of them: repelled", low=0.0)
    hold_m: float = param(60.0, unit="m", doc="R_m: farther from one of them: attracted", low=0.0)
    danger_extra_m: float = param(50.0, unit="m", doc="added to R_maxl in danger", low=0.0)
    cluster_m: float = param(160.0, unit="m", doc="R_a in safe space", low=0.0)
    cluster_danger_m: float = param(260.0, unit="m", doc="R_a in danger", low=0.0)
    safe_s: float = param(5.0, unit="s", doc="undisturbed for longer, space is safe", low=0.0)
    speed_m_s: float = param(50.0, unit="m/s", doc="desired speed of the flock", low=0.1)
    gather: float = param(0.05, unit="1/s^2", doc="K_d of gathering and dispersal", low=0.0)
    match: float = param(0.3, unit="1/s", doc="K_v of gathering and return", low=0.0)
    come_back: float = param(0.03, unit="1/s^2", doc="K_dr of return", low=0.0)
    come_back_speed: float = param(1.0, unit="1", doc="K_vr of return", low=0.0)
    escape: float = param(8.0, unit="m/s^2", doc="K_a of escape", low=0.0)
    learn: float = param(0.3, unit="1/s", doc="K_l of learning flight", low=0.0)
    explore: float = param(0.5, unit="m/s^2", doc="K_rand of free flight", low=0.0)
    spring: float = param(0.25, unit="1/s^2", doc="K_spring within R_e", low=0.0)
    pull: float = param(0.012, unit="1/s^2", doc="K_spring beyond R_m", low=0.0)
    damp: float = param(0.03, unit="1/s", doc="K_vs of the half-spring", low=0.0)
    behaviour: float = param(1.0, unit="1", doc="weight of the behaviour, Eq. (11)", low=0.0)
    single: float = param(1.0, unit="1", doc="weight of the half-spring, Eq. (11)", low=0.0)
    route: float = param(0.4, unit="1/s", doc="pull to the desired velocity along the way", low=0.0)
    abreast: float = param(
        0.8, unit="1", doc="share of its offset from the flock that is kept along the way", low=0.0
    )
    abreast_danger: float = param(
        0.3, unit="1", doc="the same in danger: a narrow formation", low=0.0
    )
    anticipate_s: float = param(3.0, unit="s", doc="closest approaches this far ahead", low=0.01)
    dodge: float = param(12.0, unit="m/s^2", doc="away from a closest approach", low=0.0)
    signs: str = param(
        "working",
        unit="-",
        doc="signs of Eqs. (7), (8), (10): those that work, or as printed",
        choices=("working", "printed"),
    )
