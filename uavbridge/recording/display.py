"""The mission in Foxglove's standard messages, beside our own in the recording.

Everything here follows from other topics, so it is no part of a recording's digest.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import ceil

import numpy as np

from planners.types import F64, Bools
from sim_vehicles.geodesy import Geodetic, to_geodetic
from uavbridge.agent.phases import Phase
from uavbridge.agent.report import AgentReport
from uavbridge.clock import SECOND_US, to_us
from uavbridge.config import Mission
from uavbridge.radio.radio import Radio
from uavbridge.recording import foxglove as fox
from uavbridge.recording.recorder import Recorder
from uavbridge.report.result import Event

CELLS_A_SECOND = 2500  # of the merged map: that of a larger area is written less often
MOST_LINKED = 100  # vehicles; links of more hide the map
FONT_PX = 14.0

_BLIND = Phase.CONNECT.value  # its position is not known yet
_CELL = np.dtype([("p_target", "<f4"), ("seen", "u1")])
_WHOLE = fox.Pose(fox.Vector3(0.0, 0.0, 0.0))
_TARGET, _DECLARED = fox.Color(0.85, 0.1, 0.4), fox.Color(0.1, 0.6, 0.45, 0.6)
_LINK, _EDGE, _INK = fox.Color(0.4, 0.5, 0.6, 0.5), fox.Color(0.5, 0.5, 0.5), fox.Color(1, 1, 1)
# Tol's "bright" scheme, as shares
_VEHICLES = tuple(
    fox.Color(r / 255, g / 255, b / 255)
    for r, g, b in (
        (68, 119, 170), (238, 102, 119), (34, 136, 51), (204, 187, 68), (102, 204, 238),
        (170, 51, 119), (187, 187, 187),
    )
)  # fmt: skip


class Display:
    """Writes what can be seen of a mission, once a second.

    Args:
        recorder: gets the messages.
        mission: with the true targets, where they are known.

    Attributes:
        logged: events so far.
    """

    def __init__(self, recorder: Recorder, mission: Mission) -> None:
        self._recorder, self._mission = recorder, mission
        home = mission.home
        self._home = Geodetic(home.latitude_deg, home.longitude_deg, home.altitude_m)
        self._radio = Radio(mission.radio.range_m)
        self._grid_us = 0
        self._declared: list[tuple[int, int]] | None = None
        self.logged = 0
        cells = mission.grid.columns * mission.grid.rows
        self._grid_every_us = SECOND_US * ceil(cells / CELLS_A_SECOND)

    def second(
        self,
        t_us: int,
        reports: Iterable[AgentReport],
        merged: tuple[F64, Bools] | None,
        declared: Iterable[tuple[int, int]],
    ) -> None:
        """The mission now.

        Args:
            t_us: mission time.
            reports: the newest of each agent.
            merged: P(target) and seen, (columns, rows), of the union of maps.
            declared: cells (column, row).
        """
        now = self._time(t_us)
        placed = sorted((r for r in reports if r.phase != _BLIND), key=lambda report: report.agent)
        if placed:
            self._vehicles(t_us, now, placed)
        if merged is not None and t_us >= self._grid_us:
            self._grid_us = t_us + self._grid_every_us
            self._recorder.record("grid", t_us, self._grid(now, *merged))
        cells = sorted(declared)
        if cells != self._declared:
            self._declared = cells
            self._recorder.record("area", t_us, self._area(now, cells))

    def log(self, events: Iterable[Event]) -> None:
        """Events that were not logged yet."""
        for event in events:
            t_us = to_us(event.t_s)
            name = "mission" if event.agent is None else f"agent {event.agent}"
            level = fox.ERROR if event.kind == "failure" else fox.INFO
            self._recorder.record("log", t_us, fox.Log(self._time(t_us), level, event.text, name))
            self.logged += 1

    def _time(self, t_us: int) -> fox.Time:
        return fox.Time.of(self._recorder.epoch_ns + t_us * 1000)

    def _vehicles(self, t_us: int, now: fox.Time, reports: Sequence[AgentReport]) -> None:
        place = np.array([report.position for report in reports])
        latitude, longitude, altitude = to_geodetic(place, self._home)
        places = zip(latitude.tolist(), longitude.tolist(), altitude.tolist(), strict=True)
        poses = []
        for report, fix in zip(reports, places, strict=True):
            pose = fox.Pose(fox.Vector3(*report.position), fox.Quaternion.of_yaw(report.heading))
            poses.append(pose)
            self._recorder.record(
                f"pose/{report.agent}", t_us, fox.PoseInFrame(now, fox.FRAME, pose)
            )
            self._recorder.record(
                f"fix/{report.agent}", t_us, fox.LocationFix(now, fox.FRAME, *fix, [0.0] * 9)
            )
        entities = [self._fleet(now, reports, poses), self._links(now, poses, place)]
        self._recorder.record("scene", t_us, fox.SceneUpdate(entities=entities))

    def _fleet(
        self, now: fox.Time, reports: Sequence[AgentReport], poses: Sequence[fox.Pose]
    ) -> fox.SceneEntity:
        size = self._mission.grid.cell_m / 3
        arrows, texts = [], []
        for report, pose in zip(reports, poses, strict=True):
            colour = _VEHICLES[report.agent % len(_VEHICLES)]
            arrows.append(
                fox.ArrowPrimitive(pose, size * 0.6, size * 0.3, size * 0.4, size * 0.6, colour)
            )
            said = f"{report.agent} {report.phase}"
            texts.append(fox.TextPrimitive(pose, True, FONT_PX, True, _INK, said))
        return fox.SceneEntity(
            timestamp=now, frame_id=fox.FRAME, id="vehicles", arrows=arrows, texts=texts
        )

    def _links(self, now: fox.Time, poses: Sequence[fox.Pose], place: F64) -> fox.SceneEntity:
        """Pairs in radio range; none where all hear all."""
        indices: list[int] = []
        if self._radio.needs_positions and len(place) <= MOST_LINKED:
            near = np.triu(self._radio.reaches(place[None, :, :], place[:, None, :]), 1)
            indices = np.argwhere(near).ravel().tolist()
        points = [pose.position for pose in poses]
        line = fox.LinePrimitive(fox.LINE_LIST, _WHOLE, 1.0, True, points, _LINK, [], indices)
        lines = [line] if indices else []
        return fox.SceneEntity(timestamp=now, frame_id=fox.FRAME, id="links", lines=lines)

    def _grid(self, now: fox.Time, probability: F64, seen: Bools) -> fox.Grid:
        grid = self._mission.grid
        cells = np.empty((grid.rows, grid.columns), _CELL)
        cells["p_target"], cells["seen"] = probability.T, seen.T
        return fox.Grid(
            timestamp=now,
            frame_id=fox.FRAME,
            pose=fox.Pose(fox.Vector3(grid.west_m, grid.south_m, 0.0)),
            column_count=grid.columns,
            cell_size=fox.Vector2(grid.cell_m, grid.cell_m),
            row_stride=grid.columns * _CELL.itemsize,
            cell_stride=_CELL.itemsize,
            fields=[
                fox.PackedElementField("p_target", 0, fox.FLOAT32),
                fox.PackedElementField("seen", 4, fox.UINT8),
            ],
            data=cells.tobytes(),
        )

    def _area(self, now: fox.Time, declared: Iterable[tuple[int, int]]) -> fox.SceneUpdate:
        """Edge of the area, true targets, declared cells."""
        grid = self._mission.grid
        west, south, east, north = grid.bounds
        corners = ((west, south), (east, south), (east, north), (west, north))
        edge = fox.LinePrimitive(
            fox.LINE_LOOP, _WHOLE, 2.0, True, [fox.Vector3(x, y, 0.0) for x, y in corners], _EDGE
        )
        side = grid.cell_m
        ball = fox.Vector3(side / 5, side / 5, side / 5)
        spheres = [
            fox.SolidPrimitive(fox.Pose(fox.Vector3(*target.position, 0.0)), ball, _TARGET)
            for target in self._mission.targets
        ]
        flat = fox.Vector3(side, side, side / 50)
        cubes = [
            fox.SolidPrimitive(fox.Pose(fox.Vector3(x, y, 0.0)), flat, _DECLARED)
            for x, y in (grid.centre_of(cell).tolist() for cell in declared)
        ]
        entity = fox.SceneEntity(
            timestamp=now,
            frame_id=fox.FRAME,
            id="area",
            lines=[edge],
            spheres=spheres,
            cubes=cubes,
        )
        return fox.SceneUpdate(entities=[entity])
