"""Followers by the modified Olfati-Saber rule: Shao 2020, Algorithm 3, Eqs. (17)-(24).

Kernels over leading axes (...): runs. Positions in cells, a step is the unit of time.

| symbol | name |
| --- | --- |
| r, epsilon, h, c_1, c_2 | ``FollowLaw`` |
| q^k, v^k | rows of ``position``, ``velocity`` |
| q^L, v^L | ``leader``, ``leader_velocity`` |

DEVIATION, the form "working"; "printed" is as printed:

* Eq. (19) sets v(t+1) equal to what is Olfati-Saber's acceleration (the text says so); v(t) is
  added.
* Eq. (19) sums a_kj (v_j - v_k): unstable with a step of 1 as soon as two neighbours are near. The
  sum is divided by that of a_kj where that is above 1.
* Eq. (21) is a vector from k to j, so that positive phi attracts; the text has it from j to k.
* Eq. (20) has a pole at 0, a step of 1 overshoots it: z counts as ``softest`` where it is less.
* Eqs. (21), (22) use the sigma norm where Olfati-Saber has the ordinary one, and scale by r where
  he has its sigma norm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.types import F64, Bools

_LEAST = 1e-6  # of a distance: phi has a pole at 0
FORMS = ("working", "printed")


@dataclass(frozen=True, slots=True)
class FollowLaw:
    """Table 2, and the radius that it leaves out."""

    radius: float = 5.0  # r, cells
    epsilon: float = 0.1
    h: float = 0.5
    c1: float = 0.6
    c2: float = 0.4
    form: str = "working"
    softest: float = 1.0  # least z of Eq. (20) in the working form


def follow(
    position: F64,
    velocity: F64,
    others: F64,
    others_velocity: F64,
    present: Bools,
    leader: F64,
    leader_velocity: F64,
    law: FollowLaw,
) -> F64:
    """Velocities (..., 2) of the next step, Eq. (19).

    Args:
        position: (..., 2).
        velocity: (..., 2) cells a step.
        others: (..., k, 2) the other followers.
        others_velocity: (..., k, 2).
        present: (..., k) which of them are heard.
        leader: (..., 2).
        leader_velocity: (..., 2).
        law: constants and form.
    """
    printed = law.form == "printed"
    apart = others - position[..., None, :]  # q_j - q_k
    squared = (apart * apart).sum(axis=-1)
    near = present & (squared < law.radius**2)  # Eq. (17)
    sigma = np.maximum(sigma_norm(squared, law.epsilon), _LEAST)
    length = sigma**2 if printed else squared
    unit = apart / np.sqrt(1.0 + law.epsilon * length)[..., None]  # Eq. (21)
    push = np.where(near, 1.0 / np.maximum(sigma, 0.0 if printed else law.softest), 0.0)  # Eq. (20)
    social = (push[..., None] * unit).sum(axis=-2) * (1.0 if printed else -1.0)
    reach = law.radius if printed else float(sigma_norm(np.array(law.radius**2), law.epsilon))
    weight = np.where(near, bump(sigma / reach, law.h), 0.0)  # Eq. (22)
    if not printed:
        weight = weight / np.maximum(weight.sum(axis=-1, keepdims=True), 1.0)
    match = (weight[..., None] * (others_velocity - velocity[..., None, :])).sum(axis=-2)
    pull = law.c1 * (position - leader) + law.c2 * (velocity - leader_velocity)
    rate = social + match - pull
    return np.asarray(rate if printed else velocity + rate)


def sigma_norm(squared: F64, epsilon: float) -> F64:
    """The sigma norm (...) of vectors of squared lengths (...), Eq. (18)."""
    return np.asarray((np.sqrt(1.0 + epsilon * squared) - 1.0) / epsilon)


def bump(z: F64, h: float) -> F64:
    """rho_h (...), 1 up to h and 0 from 1 on, Eq. (23)."""
    falling = 0.5 * (1.0 + np.cos(np.pi * (z - h) / (1.0 - h)))
    return np.where(z < h, 1.0, np.where(z < 1.0, falling, 0.0))


def flock(position: F64, velocity: F64, leader: F64, leader_velocity: F64, law: FollowLaw) -> F64:
    """Velocities (..., n, 2) of the next step of n followers that all hear each other.

    Args:
        position: (..., n, 2).
        velocity: (..., n, 2).
        leader: (..., 2).
        leader_velocity: (..., 2).
        law: constants and form.
    """
    n = position.shape[-2]
    shape = (*position.shape[:-1], n, 2)
    return follow(
        position,
        velocity,
        np.broadcast_to(position[..., None, :, :], shape),
        np.broadcast_to(velocity[..., None, :, :], shape),
        np.broadcast_to(~np.eye(n, dtype=np.bool_), shape[:-1]),
        leader[..., None, :],
        leader_velocity[..., None, :],
        law,
    )
