import io
from collections import Counter
from dataclasses import replace
from itertools import count

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from uavbridge.monitor.progress import MissionFacts, ProgressView, Snapshot, VehicleLine
from uavbridge.monitor.screen import one_line, screen

FACTS = MissionFacts("liu-2022", "esustpm", 7, "paced", 900.0, 3, 0.9, 5.0)
NAN = float("nan")


def moment(vehicles: int = 10, t_s: float = 187.0) -> Snapshot:
    lines = tuple(
        VehicleLine(i + 1, "search" if i else "return", "OFFBOARD", 30.0, 0.8, 4, "to cell 3,4")
        for i in range(vehicles)
    )
    return Snapshot(t_s, 0.78, 41.2, 2, 31.0, 14.2, 1234, 240_000, 4321, 820_000, lines, "flying")


def shown(now: Snapshot, width: int = 80, height: int = 24) -> list[str]:
    return [line.plain for line in screen(FACTS, now, factor=9.8, width=width, height=height)]


class Terminal:
    """A console that keeps what it was told, with a clock to set."""

    def __init__(self, *, terminal: bool) -> None:
        self.file = io.StringIO()
        self.console = Console(
            file=self.file, force_terminal=terminal, width=80, height=24, color_system=None
        )
        self.wall_s = 0.0

    def view(self, *, headless: bool = False) -> ProgressView:
        return ProgressView(self.console, FACTS, headless=headless, wall=lambda: self.wall_s)

    @property
    def text(self) -> str:
        return self.file.getvalue()


def test_ten_vehicles_fit_with_all_that_was_asked_for() -> None:
    lost = Counter({"out of range": 1310, "loss": 7})
    lines = shown(replace(moment(), alerts=("agent 5: link lost",), dropped=lost))
    assert len(lines) <= 23
    text = "\n".join(lines)
    for part in (
        "3:07 of 15:00", "9.8x", "78% of 90%", "41.2 bits", "2 of 3", "31.0 m now", "14.2 m so far",
        "1,234 frames sent, 240 kB", "not heard 1,310 out of range, 7 loss", "! agent 5: link lost",
    ):  # fmt: skip
        assert part in text
    rows = [line for line in lines if "OFFBOARD" in line]
    assert len(rows) == 10
    assert rows[0].split() == ["1", "return", "OFFBOARD", "30", "80", "4", "to", "cell", "3,4"]


@pytest.mark.parametrize("vehicles", [11, 25, 50, 1000])
def test_more_vehicles_go_in_two_columns_then_in_a_sum(vehicles: int) -> None:
    text = "\n".join(shown(moment(vehicles)))
    listed = text.count("OFFBOARD")
    if listed < vehicles:
        assert f"and {vehicles - listed} more: {vehicles - listed} search" in text
        assert listed >= 24
    else:
        assert "more" not in text


@given(
    vehicles=st.integers(0, 60),
    width=st.integers(20, 200),
    height=st.integers(5, 60),
    text=st.text(max_size=120),
    value=st.floats(),
    whole=st.integers(0, 10**12),
)
def test_no_line_is_too_wide_and_none_too_many(
    vehicles: int, width: int, height: int, text: str, value: float, whole: int
) -> None:
    line = VehicleLine(whole, text, text, value, value, whole, text)
    now = Snapshot(
        1.0, value, value, whole, value, value, whole, whole, whole, whole,
        (line,) * vehicles, text, (text,) * 5,
    )  # fmt: skip
    lines = screen(
        replace(FACTS, name=text, planner=text), now, factor=value, width=width, height=height
    )
    assert len(lines) <= height - 1
    assert all(line.cell_len <= width for line in lines)
    assert all(line.plain.isprintable() for line in lines)


def test_unknown_numbers_are_dashes() -> None:
    line = VehicleLine(1, "connect", "", NAN)
    text = "\n".join(shown(Snapshot(0.0, vehicles=(line,))))
    assert "nan" not in text
    assert "- now, - so far" in text


def test_a_terminal_gets_a_picture_a_few_times_a_second() -> None:
    terminal = Terminal(terminal=True)
    with terminal.view() as view:
        for tick in range(100):
            terminal.wall_s = tick * 0.01
            view.update(moment(t_s=float(tick)))
    assert terminal.text.count("coverage") in (6, 7)  # every 0.2 s, and the last
    assert "1:39 of 15:00" in terminal.text


def test_a_pipe_gets_a_line_every_few_seconds() -> None:
    terminal = Terminal(terminal=False)
    with terminal.view() as view:
        for tick in range(121):
            terminal.wall_s = tick * 0.1
            view.update(moment(t_s=float(tick)))
    lines = terminal.text.splitlines()
    assert len(lines) == 4  # at 0, 5 and 10 s, and the last
    assert lines[-1].startswith("2:00 min, coverage 78%, entropy 41.2 bits, targets 2/3")
    assert lines[-1].endswith("9 search, 1 return, 10.0x")
    assert "\x1b" not in terminal.text


def test_headless_is_plain_on_a_terminal_too() -> None:
    terminal = Terminal(terminal=True)
    with terminal.view(headless=True) as view:
        view.update(moment())
    assert terminal.text == one_line(FACTS, moment(), factor=NAN) + "\n"


def test_failures_are_told_once_and_at_once() -> None:
    terminal = Terminal(terminal=False)
    with terminal.view() as view:
        for tick in count():
            alerts = ("agent 2: refuses to arm", "agent 5: link lost")[2 - tick :]
            view.update(replace(moment(), alerts=alerts))
            if tick == 2:
                break
    assert terminal.text.count("! agent 5: link lost\n") == 1
    assert terminal.text.count("! agent 2: refuses to arm\n") == 1


def test_texts_of_others_are_no_markup() -> None:
    terminal = Terminal(terminal=False)
    with terminal.view() as view:
        view.update(replace(moment(), alerts=("[bold]agent[/] \x1b[31m",)))
    assert "[bold]agent[/]" in terminal.text
    assert "\x1b" not in terminal.text


def test_nothing_goes_to_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    terminal = Terminal(terminal=True)
    with terminal.view() as view:
        view.update(moment())
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "")
