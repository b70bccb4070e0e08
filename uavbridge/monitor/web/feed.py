"""From what is known of a mission to what one page has not been told yet.

Differences are taken against what the page was told last, never queued: a slow
page misses pictures, not facts.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from itertools import islice
from math import isfinite

import msgspec
import numpy as np
import numpy.typing as npt

from planners.types import F64, I64
from uavbridge.agent.report import AgentReport, Clocks
from uavbridge.clock import SECOND_US, to_s
from uavbridge.config.radio import radio_of
from uavbridge.monitor.maps import Maps
from uavbridge.monitor.source import Source
from uavbridge.monitor.told import terrain_of
from uavbridge.monitor.watch import MissionWatch, Point, Watched
from uavbridge.monitor.web.grounds import ground_of, layer_picture
from uavbridge.monitor.web.messages import Event, Mission, Row, Update

UNION = 0  # stands for all agents where maps are told
TRACK_POINTS = 900  # of one vehicle that a new page is told
FIRST_EVENTS = 500
LONGEST_TEXT = 300
MOST_REASONS = 20
_ENCODE = msgspec.json.Encoder().encode
Words = npt.NDArray[np.uint32]


class Feed:
    """Of one page.

    Args:
        source: of the mission.
    """

    def __init__(self, source: Source) -> None:
        self.seen_by = UNION
        self.layer = ""
        self._layer_us: int | None = None  # of the layer as the page has it
        self._source = source
        self._told: Mission | None = None
        self._watch: MissionWatch | None = None
        self._hears: list[int] | None = None
        self._flown: dict[int, int] = {}  # points of each track that were told
        self._forget()

    def next(self) -> list[str | bytes]:
        """Messages to send now: text ones are JSON, binary ones cells."""
        watch, messages = self._source.watch, list[str | bytes]()
        facts = self._facts(watch)
        if self._watch is not watch or facts != self._told:
            self._forget()
            self._watch, self._told = watch, facts
            points = [_numbers(p) for p in watch.series]
            self._points = len(points)
            self._flown = {agent.id: len(agent.track) for agent in watch.agents.values()}
            whole = msgspec.structs.replace(
                facts, t_s=to_s(max(watch.t_us, 0)), tracks=_tracks(watch), points=points
            )
            messages.append(_ENCODE(whole).decode())
            messages += self._terrain(watch)
        messages.append(_ENCODE(self._update(watch)).decode())
        maps = watch.maps
        if maps.union is not None:
            messages += self._cells(UNION, *maps.union.shown())
        own = maps.agents.get(self.seen_by)
        if own is not None:
            messages += self._cells(self.seen_by, own.probability, own.stamp_us)
        messages += self._shown_layer(maps)
        return messages

    def look(self, agent: int) -> None:
        """Tell from now on what this agent sees (0: no one's view)."""
        if self.seen_by:
            self._cells_told.pop(self.seen_by, None)
        self.seen_by = agent
        self._hears = None

    def show(self, layer: str) -> None:
        """Tell from now on of a layer; empty: of none."""
        self.layer, self._layer_us = layer, None

    def _terrain(self, watch: MissionWatch) -> list[str]:
        if watch.facts is None:
            return []
        terrain = terrain_of(watch.facts)
        return [] if terrain is None else [_ENCODE(ground_of(terrain)).decode()]

    def _shown_layer(self, maps: Maps) -> list[str]:
        """The layer that was asked for, when it is another than the page has."""
        layer = maps.layers.get(self.layer)
        if layer is None or layer.t_us == self._layer_us:
            return []
        self._layer_us = layer.t_us
        return [_ENCODE(layer_picture(self.layer, layer)).decode()]

    def _forget(self) -> None:
        self._layer_us = None
        self._layers: list[str] = []
        self._groups: list[tuple[int, int, bool]] = []
        self._hears = None
        self._rows: dict[int, Row] = {}
        self._links: list[tuple[int, int]] = []
        self._points = 0
        self._flown = {}
        self._events: int | None = None
        self._declared = 0
        self._cells_told: dict[int, Words] = {}

    def _facts(self, watch: MissionWatch) -> Mission:
        facts, source = watch.facts, self._source
        grid = watch.grid
        shared = Mission(
            name=source.name,
            recording=source.player is not None,
            orders=source.orders,
            t_s=0.0,
            grid=None
            if grid is None
            else (grid.west_m, grid.south_m, grid.cell_m, grid.columns, grid.rows),
            end_s=None if source.player is None else to_s(source.player.end_us),
            version=version("uavbridge"),
        )
        if facts is None:
            return shared
        radio_m = facts.radio.range_m
        return msgspec.structs.replace(
            shared,
            planner=facts.planner,
            seed=facts.seed,
            clock=facts.clock,
            duration_s=facts.duration,
            prior=facts.belief.prior,
            range_m=radio_m if isfinite(radio_m) else None,
            range_known=True,
            radio=radio_of(facts).words(),
            separation_m=facts.safety.separation_m if facts.safety.separation else None,
            coverage_goal=facts.coverage_goal,
            targets=[target.position for target in facts.targets],
            by_signal=facts.signals is not None,
            columns=[(*each.position, each.radius_m) for each in facts.obstacles],
        )

    def _update(self, watch: MissionWatch) -> Update:
        source, player = self._source, self._source.player
        links, rows = watch.links(), self._new_rows(watch)
        changed = links != self._links
        self._links = links
        groups = [(a, m.group, m.leads) for a, m in sorted(watch.memberships().items())]
        regrouped, self._groups = groups != self._groups, groups
        layers = sorted(watch.maps.layers)
        more, self._layers = layers != self._layers, layers
        declared = None
        finds = watch.finds.all()
        if len(finds) != self._declared:
            self._declared = len(finds)
            declared = [(*d.cell, to_s(d.t_us), d.by) for d in finds]
        points, self._points = watch.series[self._points :], len(watch.series)
        return Update(
            t_s=to_s(max(watch.t_us, 0)),
            vehicles=[_place(a) for a in watch.agents.values() if a.position is not None],
            connected=source.connected,
            silent=source.silent,
            rows=rows or None,
            links=links if changed else None,
            tracks=self._new_tracks(watch) or None,
            points=[_numbers(point) for point in points] or None,
            events=self._new_events(watch) or None,
            groups=groups if regrouped else None,
            layers=layers if more else None,
            declared=declared,
            seen_by=self.seen_by,
            hears=self._new_hears(watch),
            playing=None if player is None else player.playing,
            speed=None if player is None else player.speed,
            seeking=player is not None and player.seeking,
        )

    def _new_tracks(self, watch: MissionWatch) -> dict[int, list[float]]:
        new = {}
        for agent in watch.agents.values():
            first = self._flown.get(agent.id, 0)
            if len(agent.track) > first:
                new[agent.id] = _flat(agent.track[first:])
            self._flown[agent.id] = len(agent.track)
        return new

    def _new_rows(self, watch: MissionWatch) -> list[Row]:
        rows = [_row(agent) for agent in watch.agents.values()]
        new = [row for row in rows if self._rows.get(row.id) != row]
        self._rows.update((row.id, row) for row in new)
        return new

    def _new_events(self, watch: MissionWatch) -> list[Event]:
        first = watch.event_count - len(watch.events)
        start = watch.event_count - FIRST_EVENTS if self._events is None else self._events
        self._events = watch.event_count
        new = islice(watch.events, max(start - first, 0), None)
        return [Event(to_s(e.t_us), e.agent, e.kind[:40], e.text[:LONGEST_TEXT]) for e in new]

    def _new_hears(self, watch: MissionWatch) -> list[int] | None:
        hears = watch.hears(self.seen_by) if self.seen_by else []
        if hears == self._hears:
            return None
        self._hears = hears
        return hears

    def _cells(self, owner: int, probability: F64, stamp_us: I64) -> list[bytes]:
        """The cells of one map that look different now; all of them at first."""
        words = _words(probability, stamp_us)
        told = self._cells_told.get(owner)
        flat = np.arange(len(words)) if told is None else np.flatnonzero(told != words)
        self._cells_told[owner] = words
        if not len(flat):
            return []
        message = np.empty(2 + 2 * len(flat), "<u4")
        message[:2] = owner, len(flat)
        message[2::2], message[3::2] = flat, words[flat]
        return [message.tobytes()]


def _words(probability: F64, stamp_us: I64) -> Words:
    """(columns * rows,) values as the page has them."""
    low = np.rint(probability.reshape(-1) * 255.0).astype(np.uint32)
    second = np.where(stamp_us < 0, 0, stamp_us // SECOND_US + 1).reshape(-1)
    return low | (second.clip(max=(1 << 24) - 1).astype(np.uint32) << np.uint32(8))


def _tracks(watch: MissionWatch) -> dict[int, list[float]]:
    tracks = {}
    for agent in watch.agents.values():
        step = len(agent.track) // TRACK_POINTS + 1
        tracks[agent.id] = _flat(agent.track[::-step][::-1])  # the newest is among them
    return tracks


def _flat(track: list[tuple[float, float, float, float]]) -> list[float]:
    """x, y, x, y, ... of (t, x, y, z)."""
    return [round(part, 1) for _, x, y, _ in track for part in (x, y)]


def _numbers(point: Point) -> list[float | None]:
    return [
        to_s(point.t_us),
        _known(point.coverage, 4),
        _known(point.entropy, 1),
        point.declared,
        point.found,
        _known(point.separation_m, 2),
        point.bytes_sent,
        point.frames_sent,
    ]


def _known(value: float, digits: int) -> float | None:
    return round(value, digits) if isfinite(value) else None


def _place(agent: Watched) -> tuple[int, float, float, float, float, float, float]:
    x, y, z = agent.position or (0.0, 0.0, 0.0)
    u, v, _ = agent.velocity
    heading = agent.heading if isfinite(agent.heading) else 0.0
    return (
        agent.id,
        round(x, 2),
        round(y, 2),
        round(z, 2),
        round(u, 2),
        round(v, 2),
        round(heading, 3),
    )


def _row(agent: Watched) -> Row:
    report = agent.report
    if report is None:
        return Row(agent.id, "", "", False, False, None, 0, "", "", agent.alive, 0.0, 0, 0, [])
    return Row(
        id=agent.id,
        phase=report.phase[:40],
        mode=report.mode[:40],
        armed=report.armed,
        in_air=report.in_air,
        battery=report.battery,
        neighbours=report.neighbours,
        note=report.note[:LONGEST_TEXT],
        failure=report.failure[:LONGEST_TEXT],
        alive=agent.alive,
        distance_m=round(report.distance_m, 1),
        bytes_sent=report.bytes_sent,
        bytes_heard=report.bytes_heard,
        declared=[(column, row) for column, row, _ in report.declared],
        bytes_offered=report.bytes_offered,
        dropped=_by_reason(report.dropped),
        rejected=_by_reason(report.rejected),
        clock_ms=_clock_ms(report),
    )


def _by_reason(counts: Mapping[str, int]) -> dict[str, int]:
    return {why[:40]: number for why, number in list(counts.items())[:MOST_REASONS]}


def _clock_ms(report: AgentReport) -> tuple[float, float, float] | None:
    known = report.clocks
    if not isinstance(known, Clocks):
        return None
    offset_s, error_s, date_s = known.offset_s, known.error_s, known.date_offset_s
    return 1e3 * offset_s, 1e3 * error_s, 1e3 * date_s
