"""Liu's search with vehicles instead of point masses: multirotors with inertia, tilt and drag.

The map, the order of the decisions and the sensor are those of the point
masses. What differs: all decide once a second on where they are and what the
map says, then fly that second at once, and their velocity follows with lag.
Cells are read ten times a second, as the mission's payload sensor does.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from planners.types import F64
from sim_vehicles.dynamics.model import Setpoints
from sim_vehicles.dynamics.multirotor import Multirotor
from uavbridge.experiments.liu.methods import Method
from uavbridge.experiments.liu.setting import TICK_S, Cell, LiuParams
from uavbridge.experiments.liu.world import World

_STEP_S = 0.02
_LOOKS = 10  # a cycle
_STEPS = round(TICK_S / _STEP_S / _LOOKS)  # between two looks


class FlownWorld(World):
    """A batch of runs with every vehicle of every run in one model."""

    def __init__(
        self,
        method: Method,
        params: LiuParams,
        draws: Sequence[Generator],
        targets: Sequence[Cell],
        prior: F64 | float,
    ) -> None:
        super().__init__(method, params, draws, targets, prior)
        runs, team = self.position.shape[:2]
        count = runs * team
        start = np.tile(method.scenario.starts, (runs, 1))
        self._model = Multirotor(start, np.full(count, np.pi / 2.0))
        self._asked = Setpoints.idle(count)
        self._asked.motors[:] = True
        self._asked.position[:, 2] = start[:, 2]
        self._calm = np.zeros((count, 3))

    def step(self) -> None:
        """One cycle: all decide, fly for a second, and read the cells they come into."""
        wishes = np.stack(
            [self._decision(agent, self._now()) for agent in range(self.position.shape[1])], axis=1
        )
        pace = self.method.scenario.tick_s / TICK_S  # of the reading whose cycle lasts 10 ms
        self._asked.velocity[:, :2] = (wishes * pace).reshape(-1, 2)
        for _ in range(_LOOKS):
            for _ in range(_STEPS):
                self._model.step(self._asked, self._calm, _STEP_S)
            self._look()
        if self.params.update_on == "cycle":
            for agent in range(self.position.shape[1]):
                self._read(self.cell[:, agent], self.running)
        self.cycle += 1

    def _look(self) -> None:
        flying = self.running[:, None, None]
        states = self._model.states
        shape = self.position.shape
        self.position = np.where(flying, states.position[:, :2].reshape(shape), self.position)
        self.velocity = np.where(flying, states.velocity[:, :2].reshape(shape), 0.0)
        for agent in range(shape[1]):
            entered = self._enter(agent)
            if self.params.update_on == "entry":
                self._read(self.cell[:, agent], entered)
