"""Figures as SVG and PNG: in the report, and as files beside it for papers."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO, StringIO
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from uavbridge.report import aircraft, figures
from uavbridge.report.overlays import layers_figure
from uavbridge.report.result import MissionResult

PNG_DPI = 200
_XML = '<?xml version="1.0" encoding="utf-8"?>\n'


@dataclass(frozen=True, slots=True)
class Drawn:
    """One figure."""

    name: str  # of its files
    svg: str  # an element that can stand in HTML
    png: bytes


def drawings(
    result: MissionResult, progress: Callable[[str], None] = lambda _name: None
) -> dict[str, Drawn]:
    """All figures of a mission, by name; the same bytes each time.

    Args:
        result: of the mission.
        progress: told the name of each figure before it is drawn.
    """
    made: dict[str, tuple[Callable[[], Figure], str]] = {
        "map": (lambda: figures.map_figure(result), "Tracks over the final map"),
        "progress": (
            lambda: figures.progress_figure(result),
            "Coverage, entropy and targets over time",
        ),
        "separation": (
            lambda: figures.separation_figure(result),
            "Distance of the closest pair over time",
        ),
        "radio": (
            lambda: figures.bytes_figure(result.agents),
            "Bytes sent and heard by each agent",
        ),
    }
    if result.layers:
        made["layers"] = (
            lambda: layers_figure(result.layers, result.columns),
            "Layers of numbers over the area, as they were last",
        )
    if result.alliances is not None:
        made["alliances"] = (
            lambda: figures.alliances_figure(result),
            "Members of suballiances over time",
        )
    if result.planes:
        made["space"] = (
            lambda: aircraft.tracks_figure(result.tracks, result.terrain),
            "Tracks in space",
        )
        made["motion"] = (
            lambda: aircraft.motion_figure(result.tracks),
            "Yaw, pitch and speed over time",
        )
    done = {}
    for name, (draw, title) in made.items():
        progress(name)
        done[name] = drawn(name, draw(), title)
    return done


def drawn(name: str, figure: Figure, title: str) -> Drawn:
    """A figure as SVG and PNG; ``title`` is for those who cannot see it."""
    text = StringIO()
    with mpl.rc_context({"svg.hashsalt": title, "svg.fonttype": "none"}):
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None})
    figure.set_layout_engine("none")  # laid out already; again would take as long as drawing
    image = BytesIO()
    quick = {"compress_level": 1}  # the next levels take half as long again for a tenth less
    figure.savefig(image, format="png", dpi=PNG_DPI, metadata={"Software": None}, pil_kwargs=quick)
    return Drawn(name, _element(text.getvalue(), title), image.getvalue())


def write_files(made: dict[str, Drawn], folder: Path) -> None:
    """Write ``<name>.svg`` and ``<name>.png`` of each into a folder, made where it is not."""
    folder.mkdir(exist_ok=True)
    for one in made.values():
        (folder / f"{one.name}.svg").write_text(_XML + one.svg, encoding="utf-8")
        (folder / f"{one.name}.png").write_bytes(one.png)


def _element(svg: str, title: str) -> str:
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    # The page's own fonts instead of those of this machine.
    svg = re.sub(r"(font: [^'\";]*?px) [^;\"]*", r"\1 system-ui, sans-serif", svg)
    return svg.replace("<svg ", f'<svg role="img" aria-label="{title}" ', 1)
