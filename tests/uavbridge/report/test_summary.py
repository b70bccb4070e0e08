import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavbridge.report.quantity import data_size, duration, number, plain
from uavbridge.report.result import AgentResult, MissionResult, TargetResult
from uavbridge.report.summary import summary_json, summary_text

FIELDS = [
    "mission", "seed", "clock", "duration_s", "wall_s", "coverage", "uncertainty", "entropy",
    "targets", "false_targets", "agents", "min_separation_m", "failures", "deaths", "digest", "out",
    "radio", "ticks", "late_ticks",
]  # fmt: skip


def test_document_has_the_published_fields_in_order(flown: MissionResult) -> None:
    document = json.loads(summary_json(flown))
    assert list(document) == FIELDS
    assert document["targets"] == [
        {"cell": [2, 7], "found_at_s": 81.0, "by": 3},
        {"cell": [8, 8], "found_at_s": None, "by": None},
    ]
    assert document["false_targets"] == [[4, 4]]
    assert list(document["agents"][0]) == [
        "id", "state", "distance_m", "frames_sent", "frames_heard", "bytes_sent", "bytes_heard",
        "bytes_offered", "map_bytes_sent", "dropped", "dropped_bytes", "rejected",
        "clock_offset_s", "clock_error_s", "date_offset_s",
    ]  # fmt: skip
    assert document["failures"] == ["agent 2: link lost"]


def test_unknown_numbers_are_null(flown: MissionResult) -> None:
    alone = replace(flown, min_separation_m=float("inf"), entropy=float("nan"))
    document = json.loads(summary_json(alone), parse_constant=pytest.fail)
    assert document["min_separation_m"] is None
    assert document["entropy"] is None


@given(st.text(st.characters(exclude_categories=()), max_size=20))
def test_any_text_gives_a_document(flown: MissionResult, text: str) -> None:
    odd = replace(flown, mission=text, out=text, failures=(text,))
    document = json.loads(summary_json(odd))
    assert document["mission"] == document["failures"][0]
    if text.isascii():
        assert document["mission"] == text


def test_screen_says_what_matters(flown: MissionResult) -> None:
    text = summary_text(flown)
    for part in (
        "goal reached",
        "10:00",
        "96.0 %",
        "1 of 2 declared, 1 false",
        "10.0 m",
        "ab" * 32,
    ):
        assert part in text
    assert "NOT reached" in summary_text(replace(flown, reached_goal=False))


@given(
    targets=st.integers(0, 30),
    failures=st.lists(st.text(max_size=200), max_size=30),
    agents=st.lists(st.text(max_size=30), max_size=30),
    name=st.text(max_size=200),
)
def test_screen_fits_80_by_24(
    flown: MissionResult, targets: int, failures: list[str], agents: list[str], name: str
) -> None:
    crowded = replace(
        flown,
        mission=name,
        targets=tuple(TargetResult((n, n)) for n in range(targets)),
        failures=tuple(failures),
        agents=tuple(AgentResult(n, state, 1e7, 10**9) for n, state in enumerate(agents)),
    )
    lines = summary_text(crowded).split("\n")
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80
    assert all(line.isprintable() for line in lines)


def test_the_path_of_the_output_is_never_cut(flown: MissionResult) -> None:
    path = "/home/somebody/" + "long/" * 20 + "demo"
    assert path in summary_text(replace(flown, out=path))


def test_quantities() -> None:
    assert [duration(s) for s in (7, 187, 3723, float("nan"))] == ["0:07", "3:07", "1:02:03", "-"]
    assert [data_size(n) for n in (0, 999, 1200, 240_000, 3_400_000, 5e9)] == [
        "0 B", "999 B", "1.2 kB", "240 kB", "3.4 MB", "5.0 GB",
    ]  # fmt: skip
    assert [number(v, "m") for v in (5, 12.34, 1234.5, float("inf"))] == [
        "5.00 m", "12.3 m", "1234 m", "-",
    ]  # fmt: skip
    assert plain("a\x1b[31mb\nc") == "a [31mb c"


def test_what_is_emulated_and_what_became_of_it_are_told_whole(flown: MissionResult) -> None:
    radio = "range 1000 m, loss 0.05, bursts of 4 ticks (0.181 lost in all), delay 0.2 s, 100 B/s"
    agent = replace(flown.agents[0], dropped=dict.fromkeys(map(str, range(10**6, 10**6 + 20)), 7))
    text = summary_text(replace(flown, radio=radio, agents=(agent,)))
    whole = " ".join(text.split())
    assert radio in whole
    assert "7 1000019" in whole
    assert max(map(len, text.split("\n"))) <= 80


def test_notes_are_told_whole(flown: MissionResult) -> None:
    note = "recorded from the bus: what each radio delivered and the decisions are not in it"
    text = summary_text(replace(flown, notes=(note,)))
    assert note in " ".join(text.split())
    assert max(map(len, text.split("\n"))) <= 80
