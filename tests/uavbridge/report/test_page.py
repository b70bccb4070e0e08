import re
import struct
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.grid import Grid
from planners.terrain import Terrain
from uavbridge.report import figures, page
from uavbridge.report.drawn import drawings, drawn
from uavbridge.report.page import report_page, write_report
from uavbridge.report.result import AgentResult, Event, MissionResult, TargetResult


class Reader(HTMLParser):
    """Collects tags, attributes and text as a browser would see them."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: set[str] = set()
        self.text = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes |= {name for name, _ in attrs}

    def handle_data(self, data: str) -> None:
        self.text += data


def test_the_report_holds_everything(flown: MissionResult, tmp_path: Path) -> None:
    path = write_report(flown, tmp_path)
    assert (tmp_path / "summary.json").exists()
    reader = Reader(path.read_text(encoding="utf-8"))
    assert reader.tags.count("svg") == 4
    for part in (
        "demo", "goal reached", "agent 2: link lost", "declares cell 2,7", flown.digest,
        "uavbridge launch mission.toml --seed 7", 'name = "demo"', "false: nothing there",
    ):  # fmt: skip
        assert part in reader.text


def test_the_report_needs_no_network_and_no_script(flown: MissionResult) -> None:
    text = report_page(flown, drawings(flown))
    reader = Reader(text)
    assert not {"script", "link", "img", "iframe", "object", "embed"} & set(reader.tags)
    addresses = set(re.findall(r"https?://[^\"'\s)]+", text))
    assert all(address.startswith("http://www.w3.org/") for address in addresses)  # XML names
    assert not re.search(r"url\((?!#)", text)
    assert "default-src 'none'" in text


def test_flights_of_aircraft_are_drawn_in_space_and_over_time(flown: MissionResult) -> None:
    turn = np.linspace(0.0, 3.0, 40)
    track = np.column_stack((900.0 * np.sin(turn), 900.0 * np.cos(turn), 100.0 + 5.0 * turn))
    tracks = {1: track, 2: track + 30.0, 3: track[:2], 4: np.zeros((0, 3))}
    hills = Terrain(-1000.0, -1000.0, 50.0, np.zeros((41, 41)))
    made = drawings(replace(flown, planes=True, tracks=tracks, terrain=hills))
    assert {"space", "motion"} <= set(made)
    reader = Reader(report_page(replace(flown, planes=True), made))
    assert "Tracks in space over the terrain" in reader.text
    assert "space" not in drawings(flown)


def test_the_report_is_the_same_each_time(flown: MissionResult) -> None:
    assert report_page(flown, drawings(flown)) == report_page(flown, drawings(flown))


def test_pictures_stand_beside_the_page_for_papers(flown: MissionResult, tmp_path: Path) -> None:
    write_report(flown, tmp_path)
    names = set(page.FIGURES)
    files = {path.name for path in (tmp_path / "figures").iterdir()}
    assert files == {f"{name}.{kind}" for name in names for kind in ("svg", "png")}
    page_text = (tmp_path / "report.html").read_text(encoding="utf-8")
    for name in names:
        svg = (tmp_path / "figures" / f"{name}.svg").read_text(encoding="utf-8")
        assert ElementTree.fromstring(svg.encode()).tag.endswith("svg")
        assert svg.partition("\n")[2] in page_text
        png = (tmp_path / "figures" / f"{name}.png").read_bytes()
        width, height = struct.unpack(">II", png[16:24])
        assert png.startswith(b"\x89PNG")
        assert width > 1400
        assert height > 400


MARKUP = st.sampled_from(
    [
        "<script>alert(1)</script>",
        '"><img src=x onerror=alert(1)>',
        "</pre></style><b>",
        "&amp;<!--",
        "{title}",
        "]]>",
        "$\\frac{1}{2}$",
        "\x1b[31m",
        "<svg onload=alert(1)>",
        "' onclick='x",
    ]
)


@given(text=st.lists(MARKUP | st.text(min_size=1, max_size=20), min_size=1, max_size=4))
@settings(max_examples=60)
def test_no_text_can_become_markup(flown: MissionResult, text: list[str]) -> None:
    words = "clean", "".join(text)
    clean, dirty = (_head_and_tables(_with_text(flown, word)) for word in words)
    assert dirty.tags == clean.tags
    assert dirty.attributes == clean.attributes


def _with_text(flown: MissionResult, text: str) -> MissionResult:
    return replace(
        flown,
        mission=text, clock=text, failures=(text,), mission_text=text, versions={text: text},
        repeat=text, digest=text, out=text, events=(Event(1.0, text, 2),),
        agents=(AgentResult(1, text),),
    )  # fmt: skip


def _head_and_tables(result: MissionResult) -> Reader:
    """The page without the slow pictures, which hold no text but agent ids."""
    parts = (
        page._head(result),
        page._targets(result),
        page._agents(result.agents),
        page._events(result),
        page._repeat(result),
        page._section("Mission file", page._mission_file(result)),
    )
    return Reader("\n".join(parts))


def test_a_hostile_mission_stays_text_on_the_whole_page(flown: MissionResult) -> None:
    text = "</title><script>alert('x')</script>{style}%s"
    reader = Reader(report_page(_with_text(flown, text), drawings(flown)))
    assert "script" not in reader.tags
    assert reader.text.count(text) >= 8


def test_a_mission_that_never_began_has_a_report(tmp_path: Path) -> None:
    nothing = MissionResult(
        mission="none", seed=0, clock="paced", duration_s=0.0, wall_s=0.0, reached_goal=False,
        grid=Grid(0.0, 0.0, 50.0, 3, 2), failures=("agent 1: never reported",),
    )  # fmt: skip
    assert "goal missed" in write_report(nothing, tmp_path).read_text(encoding="utf-8")


@pytest.mark.parametrize("agents", [1, 40])
def test_any_number_of_agents_can_be_drawn(flown: MissionResult, agents: int) -> None:
    many = replace(
        flown,
        tracks={agent: flown.tracks[1] + agent for agent in range(agents)},
        agents=tuple(AgentResult(agent, "landed", bytes_sent=agent) for agent in range(agents)),
        targets=tuple(TargetResult((c, 0)) for c in range(10)),
    )
    assert "<svg" in drawn("map", figures.map_figure(many), "m").svg
    assert "<svg" in drawn("bytes", figures.bytes_figure(many.agents), "b").svg


def test_gaps_in_the_series_are_drawn_as_gaps(flown: MissionResult) -> None:
    silent = replace(
        flown, series=replace(flown.series, separation_m=np.full(len(flown.series.t_s), np.nan))
    )
    assert "<svg" in drawn("s", figures.separation_figure(silent), "s").svg


def test_what_the_radio_lost_is_told_by_reason(flown: MissionResult) -> None:
    agents = tuple(
        replace(
            agent,
            bytes_offered=95_000,
            dropped={"out of range": 1200, "loss": 3},
            dropped_bytes={"out of range": 120_000, "loss": 300},
            rejected={"future": 2},
        )
        for agent in flown.agents
    )
    text = page._accounts(agents)
    for row in (
        'offered by the agents</td><td></td><td class="n">285 kB',
        'not heard: out of range</td><td>3,600</td><td class="n">360 kB',
        'not heard: loss</td><td>9</td><td class="n">900 B',
        "rejected: future</td><td>2<",
    ):
        assert row in text
