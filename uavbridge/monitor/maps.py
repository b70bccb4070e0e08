"""All maps of a mission as an onlooker knows them: the grid, the union, one of each agent."""

from __future__ import annotations

from math import nan

from planners.belief.merge import SensorModel
from planners.belief.scores import entropy, uncertainty
from planners.grid import Grid
from planners.types import F64, Bools
from uavbridge.bus.layers import Layer
from uavbridge.bus.messages import FullMap
from uavbridge.bus.wire import Frame
from uavbridge.config import Mission
from uavbridge.monitor.shown import AgentMap, UnionMap, readable

UNKNOWN_PRIOR = 0.5
MOST_LAYERS = 64


class Maps:
    """Empty until a mission or a whole map tells of the grid.

    Attributes:
        grid: the search area; None until somebody told.
        union: of all agents' maps; None without a grid.
        agents: each agent's own, by id.
        layers: other numbers over the ground, the newest of each name.
    """

    def __init__(self) -> None:
        self.grid: Grid | None = None
        self.union: UnionMap | None = None
        self.agents: dict[int, AgentMap] = {}
        self.layers: dict[str, Layer] = {}
        self._prior: float | F64 = UNKNOWN_PRIOR
        self._sensor = SensorModel()
        self._team: tuple[int, ...] = ()
        self._told: dict[int, tuple[Frame, ...]] = {}  # the last two of each with cells

    def take_mission(self, mission: Mission) -> None:
        """The mission as it is flown; maps of another grid are void."""
        try:
            self._team = tuple(member.id for member in mission.team())
        except ValueError:  # no room for so many: nobody flies this
            self._team = ()
        if self.grid != mission.grid:
            sensor = SensorModel(mission.sensor.p, mission.sensor.q, mission.belief.update)
            self._lay_out(mission.grid, mission.prior(), sensor)

    def take_full(self, full: FullMap) -> bool:
        """One agent's whole map; False where it does not fit the grid."""
        columns, rows = full.probability.shape
        if self.grid is None:
            grid = Grid(full.west_m, full.south_m, full.cell_m, columns, rows)
            unseen = full.probability[full.stamp_us < 0]
            prior = float(unseen[0]) if len(unseen) else UNKNOWN_PRIOR
            self._lay_out(grid, prior, SensorModel())
        g = self.grid
        if g is None or self.union is None:
            return False
        if (columns, rows, full.west_m, full.south_m) != (g.columns, g.rows, g.west_m, g.south_m):
            return False
        self.union.take_map(full)
        self._of(g, full.agent).take_map(full)
        return True

    def take_frame(self, frame: Frame) -> bool:
        """The cells of a frame; False where nobody here can read them."""
        content = readable(frame)
        if content is None:
            return False
        if self.grid is not None and self.union is not None:
            self._heard(self.grid, frame)
            if len(content[1]):
                self.union.take_records(*content)
                self._of(self.grid, frame.sender).take_frame(frame, *content)
        return True

    def _heard(self, grid: Grid, frame: Frame) -> None:
        """What others told goes to who says that it heard them, a tick later."""
        for i, agent in enumerate(self._team if frame.heard else ()):
            if frame.heard >> i & 1:
                for told in self._told.get(agent, ()):
                    content = readable(told) if told.tick == frame.tick - 1 else None
                    if content is not None:
                        self._of(grid, frame.sender).hear(told, *content)
        if frame.cells:
            self._told[frame.sender] = (*self._told.get(frame.sender, ())[-1:], frame)

    def take_layer(self, name: str, layer: Layer) -> bool:
        """Numbers over the ground; False for one too many."""
        if name not in self.layers and len(self.layers) >= MOST_LAYERS:
            return False
        before = self.layers.get(name)
        if before is None or before.t_us <= layer.t_us:
            self.layers[name] = layer
        return True

    def merged(self) -> tuple[F64, Bools] | None:
        """Probability and seen, (columns, rows), of the union; None without a grid."""
        if self.union is None:
            return None
        probability, stamp_us = self.union.shown()
        return probability, stamp_us >= 0

    def scores(self) -> tuple[float, float, float]:
        """Share of cells seen, entropy in bits, one-sided uncertainty; NaN without a grid."""
        merged = self.merged()
        if merged is None:
            return nan, nan, nan
        probability, seen = merged
        return float(seen.mean()), float(entropy(probability)), float(uncertainty(probability))

    def _lay_out(self, grid: Grid, prior: float | F64, sensor: SensorModel) -> None:
        self.grid, self._prior, self._sensor = grid, prior, sensor
        self.union = UnionMap(grid, prior, sensor)
        self.agents = {}

    def _of(self, grid: Grid, agent: int) -> AgentMap:
        shown = self.agents.get(agent)
        if shown is None:
            shown = self.agents[agent] = AgentMap(grid, self._prior, self._sensor)
        return shown
