"""Maps of all UAVs of all runs, as arrays: by values (BU, AVG, OGMM, MOGM), by readings (SDS).

The arithmetic is that of ``planners.belief``; a test holds every step equal to
single maps behind the merge rules' seam.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planners.belief.evidence import posterior
from planners.belief.fusing import Cells, FusingRule, mix
from planners.belief.maps import stored
from planners.belief.newest import BeliefUpdate, beats
from planners.belief.rule import MergeRule
from planners.types import F64, I64, Bools
from uavbridge.experiments.khan.choices import KhanParams, rules
from uavbridge.experiments.khan.world import Team


class ValueTeam:
    """One stamped value a cell.

    Args:
        rule: how values merge; with neither BU nor a fusing rule nobody listens.
        choices: the setting.
        runs: how many.
        uavs: N.
    """

    def __init__(self, rule: MergeRule, choices: KhanParams, runs: int, uavs: int) -> None:
        shape = (runs, uavs, choices.columns * choices.rows)
        self.probability = np.full(shape, 0.5)
        self.bytes_sent = np.zeros(runs)
        self._stamp = np.full(shape, -1, np.int64)
        self._origin = np.full(shape, -1, np.int32)
        self._rule = rule
        self._exchange = choices.exchange
        self._sensor = choices.sensor

    def observe(self, cells: I64, detected: Bools, who: I64, t_us: int) -> None:
        at = places(self.probability, np.arange(len(cells))[:, None], who, cells[:, who])
        value, stamp = self.probability.reshape(-1), self._stamp.reshape(-1)
        value[at] = stored(self._sensor.after(value[at], detected[:, who]))
        stamp[at] = np.maximum(stamp[at] + 1, t_us)
        self._origin.reshape(-1)[at] = who

    def exchange(self, reach: Bools, cells: I64, who: I64) -> None:
        if not isinstance(self._rule, BeliefUpdate | FusingRule) or not reach.any():
            return
        told = {"current": self._current, "contested": self._contested, "whole": self._whole}
        parts = told[self._exchange](reach, cells, who)
        # All is read before anything is written: they speak at the same time.
        merged = [self._merged(*part) for part in parts]
        for at, after in merged:
            self._write(at, after)

    def merge(self, at: I64, heard: Cells, present: Bools) -> I64:
        """Merge what was heard (m, n) of the cells at flat places (m,); which of them changed."""
        after, changed = self._fused(self.cells(at), heard, present & (heard.stamp >= 0))
        pick = at[changed]
        self._write(pick, Cells(after.value[changed], after.stamp[changed], after.origin[changed]))
        return pick

    def fade(self, share: float) -> None:
        odds = (self.probability / (1.0 - self.probability)) ** (1.0 - share)
        self.probability = odds / (1.0 + odds)

    def keep(self, runs: Bools) -> None:
        self.bytes_sent = self.bytes_sent[runs]
        self.probability = self.probability[runs]
        self._stamp, self._origin = self._stamp[runs], self._origin[runs]

    def _current(self, reach: Bools, cells: I64, who: I64) -> list[_Heard]:
        """Those whose turn it is send the value of their own cell."""
        run, uav, turn = np.nonzero(reach[:, :, who])
        sender = who[turn]
        cell = cells[run, sender]
        sends = np.zeros(cells.shape[1], np.bool_)
        sends[who] = True
        shared = (cells[:, :, None] == cells[:, None, :]).sum(axis=2) > 1
        crowd = shared[run, sender]  # more than one may speak of the cell
        alone = ~crowd
        single = _Heard(
            run[alone],
            uav[alone],
            cell[alone],
            sender[alone, None],
            np.ones((alone.sum(), 1), bool),
        )
        if not crowd.any():
            return [single]
        run, uav, cell = run[crowd], uav[crowd], cell[crowd]
        present = reach[run, uav] & sends & (cells[run] == cell[:, None])
        return [single, _Heard.of_all(run, uav, cell, present)]

    def _contested(self, reach: Bools, cells: I64, who: I64) -> list[_Heard]:
        """All in range send what they hold of each cell just observed in the receiver's range."""
        near = reach | np.eye(cells.shape[1], dtype=np.bool_)
        run, uav, turn = np.nonzero(near[:, :, who])
        return [_Heard.of_all(run, uav, cells[run, who[turn]], reach[run, uav])]

    def _whole(self, reach: Bools, cells: I64, who: I64) -> list[_Heard]:
        """Those whose turn it is send all that they hold."""
        differs = np.zeros(self._stamp.shape, np.bool_)
        for sender in who:
            stamp, origin = self._stamp[:, sender, None], self._origin[:, sender, None]
            news = (stamp >= 0) & ((stamp != self._stamp) | (origin != self._origin))
            differs |= reach[:, :, sender, None] & news
        run, uav, cell = np.nonzero(differs)
        sends = np.zeros(cells.shape[1], np.bool_)
        sends[who] = True
        return [_Heard.of_all(run, uav, cell, reach[run, uav] & sends)]

    def _merged(
        self, run: I64, uav: I64, cell: I64, sender: I64, present: Bools
    ) -> tuple[I64, Cells]:
        """Where cells changed, in the flat maps, and what they became."""
        at = places(self.probability, run, uav, cell)
        own = self.cells(at)
        heard = self.cells(places(self.probability, run[:, None], sender, cell[:, None]))
        after, changed = self._fused(own, heard, present & (heard.stamp >= 0))
        return at[changed], Cells(after.value[changed], after.stamp[changed], after.origin[changed])

    def _fused(self, own: Cells, heard: Cells, present: Bools) -> tuple[Cells, Bools]:
        if isinstance(self._rule, FusingRule):
            return mix(self._rule, own, heard, present)
        return newest(own, heard, present)

    def _write(self, at: I64, cells: Cells) -> None:
        self.probability.reshape(-1)[at] = cells.value
        self._stamp.reshape(-1)[at] = cells.stamp
        self._origin.reshape(-1)[at] = cells.origin

    def cells(self, at: I64) -> Cells:
        """What is held at flat places (...)."""
        return Cells(
            self.probability.reshape(-1)[at],
            self._stamp.reshape(-1)[at],
            self._origin.reshape(-1)[at],
        )


class _Heard(NamedTuple):
    """What receivers hear of cells: (m,) each, the senders (m, n), and who of them speaks."""

    run: I64
    uav: I64
    cell: I64
    sender: I64
    present: Bools

    @staticmethod
    def of_all(run: I64, uav: I64, cell: I64, present: Bools) -> _Heard:
        """With a place (m, N) for every UAV."""
        return _Heard(run, uav, cell, np.arange(present.shape[1])[None], present)


def places(maps: F64, run: I64, uav: I64, cell: I64) -> I64:
    """Places of cells in flat maps (runs, N, cells)."""
    return np.asarray((run * maps.shape[1] + uav) * maps.shape[2] + cell)


class ReadingTeam:
    """All readings that each UAV knows: as many as it has heard of from each, in their order.

    Contacts hand over whole histories, so that what one knows of another is always
    the beginning of its log, and its length says it all.
    """

    def __init__(self, choices: KhanParams, runs: int, uavs: int) -> None:
        shape = (runs, uavs, choices.columns * choices.rows)
        self.probability = np.full(shape, 0.5)
        self.bytes_sent = np.zeros(runs)
        self._hits = np.zeros(shape)
        self._misses = np.zeros(shape)
        self._known = np.zeros((runs, uavs, uavs), np.int64)  # of whom on axis 2
        self._log_cell = np.zeros((runs, uavs, 256), np.int32)
        self._log_hit = np.zeros((runs, uavs, 256), np.bool_)
        self._sensor = choices.sensor
        self._steps = 0
        self._left = 1.0  # of a reading, a step later
        self._whole = choices.history == "whole"

    def observe(self, cells: I64, detected: Bools, who: I64, t_us: int) -> None:
        length = int(self._known[0, who[0], who[0]]) if len(cells) else 0
        if length == self._log_cell.shape[2]:
            self._log_cell = np.concatenate([self._log_cell, np.zeros_like(self._log_cell)], axis=2)
            self._log_hit = np.concatenate([self._log_hit, np.zeros_like(self._log_hit)], axis=2)
        self._log_cell[:, who, length] = cells[:, who]
        self._log_hit[:, who, length] = detected[:, who]
        self._known[:, who, who] += 1
        self._steps = length + 1
        run = np.repeat(np.arange(len(cells)), len(who))
        uav = np.tile(who, len(cells))
        self._count(run, uav, cells[:, who].reshape(-1), detected[:, who].reshape(-1), length)

    def exchange(self, reach: Bools, cells: I64, who: I64) -> None:
        if reach.shape[1] == 1:
            return
        told = np.zeros_like(reach)
        told[:, :, who] = reach[:, :, who]
        if self._whole:
            offered = np.where(told[..., None], self._known[:, None], 0).max(axis=2)
            first = self._known.copy()
            self._known = np.maximum(first, offered)
            run, uav, whose = np.nonzero(self._known > first)
            more = (self._known - first)[run, uav, whose]
            place = np.arange(more.sum()) - np.repeat(np.cumsum(more) - more, more)
            place += np.repeat(first[run, uav, whose], more)
            run, uav, whose = (np.repeat(part, more) for part in (run, uav, whose))
        else:
            run, uav, whose = np.nonzero(told)
            place = self._known[run, whose, whose] - 1
        cell, hit = self._log_cell[run, whose, place], self._log_hit[run, whose, place]
        self._count(run, uav, cell, hit, place)

    def fade(self, share: float) -> None:
        self._left = 1.0 - share
        self._hits *= self._left
        self._misses *= self._left
        self.probability = posterior(0.5, self._hits, self._misses, self._sensor)

    def keep(self, runs: Bools) -> None:
        self.bytes_sent = self.bytes_sent[runs]
        self.probability, self._known = self.probability[runs], self._known[runs]
        self._hits, self._misses = self._hits[runs], self._misses[runs]
        self._log_cell, self._log_hit = self._log_cell[runs], self._log_hit[runs]

    def _count(self, run: I64, uav: I64, cell: I64, hit: Bools, place: I64 | int) -> None:
        """Readings (k,) that UAVs now know of, by their places in the logs."""
        at = places(self.probability, run, uav, cell)
        hits, misses = self._hits.reshape(-1), self._misses.reshape(-1)
        weight = self._left ** (self._steps - 1.0 - place) if self._left < 1.0 else 1.0
        np.add.at(hits, at, hit * weight)
        np.add.at(misses, at, ~hit * weight)
        self.probability.reshape(-1)[at] = posterior(0.5, hits[at], misses[at], self._sensor)


def team_of(rule: str, choices: KhanParams, runs: int, uavs: int) -> Team:
    """A fresh team under one of the paper's strategies."""
    if rule == "SDS":
        return ReadingTeam(choices, runs, uavs)
    return ValueTeam(rules(choices)[rule], choices, runs, uavs)


def newest(own: Cells, heard: Cells, present: Bools) -> tuple[Cells, Bools]:
    """The greatest of own cells (...) and those heard (..., n): Eq. (2)."""
    value, stamp, origin = own
    for k in range(present.shape[-1]):
        other = Cells(heard.value[..., k], heard.stamp[..., k], heard.origin[..., k])
        wins = present[..., k] & beats(other.stamp, other.origin, other.value, stamp, origin, value)
        value = np.where(wins, other.value, value)
        stamp = np.where(wins, other.stamp, stamp)
        origin = np.where(wins, other.origin, origin)
    return Cells(value, stamp, origin), np.asarray(stamp != own.stamp) | (value != own.value)
