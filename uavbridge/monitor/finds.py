"""What agents say that they found: cells they declare, targets they reached by their signals."""

from __future__ import annotations

from collections.abc import Iterator

from uavbridge.agent.report import AgentReport
from uavbridge.config import Mission
from uavbridge.monitor.watched import Declared


class Finds:
    """The first who said so counts, whoever was heard first.

    Attributes:
        declared: by cell.
        reached: by number of the target, where targets give signals.
    """

    def __init__(self) -> None:
        self.declared: dict[tuple[int, int], Declared] = {}
        self.reached: dict[int, Declared] = {}
        self._mission: Mission | None = None
        self._true_cells: frozenset[tuple[int, int]] = frozenset()

    @property
    def found(self) -> int | None:
        """True targets found; None when the true ones are not known."""
        if self._mission is None:
            return None
        if self._mission.signals is not None:
            return len(self.reached)
        return sum(cell in self._true_cells for cell in self.declared)

    def all(self) -> list[Declared]:
        """Both kinds."""
        return [*self.declared.values(), *self.reached.values()]

    def take_mission(self, mission: Mission) -> None:
        """The mission as it is flown."""
        self._mission = mission
        self._true_cells = frozenset(mission.target_cells())

    def take(self, report: AgentReport) -> Iterator[tuple[int, str]]:
        """Time and text of what nobody has said before."""
        for column, row, t_us in report.declared:
            cell = column, row
            if cell not in self.declared:
                yield t_us, f"target in cell {column}, {row}"
            find = Declared(cell, t_us, report.agent)
            self.declared[cell] = _earlier(self.declared.get(cell), find)
        targets = () if self._mission is None else self._mission.targets
        for number, t_us in report.found:
            if self._mission is None or not 0 <= number < len(targets):
                continue
            if number not in self.reached:
                yield t_us, f"target {number} reached"
            column, row = self._mission.grid.cell_of(targets[number].position).tolist()
            find = Declared((column, row), t_us, report.agent)
            self.reached[number] = _earlier(self.reached.get(number), find)


def _earlier(known: Declared | None, new: Declared) -> Declared:
    return new if known is None or (new.t_us, new.by) < (known.t_us, known.by) else known
