"""An outcome for people and programs: the table, and the files in a folder."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import msgspec
from rich.console import Console
from rich.table import Table

from uavbridge.experiments import printed
from uavbridge.experiments.experiment import Outcome
from uavbridge.experiments.intervals import t_quantile
from uavbridge.experiments.rows import Row

_NUMBERS = 4  # last columns of the table: paper, ours, spread, n
_FIGURES = ("paper", "mean", "se", "median", "q25", "q75", "n")


def as_json(rows: Sequence[Row]) -> bytes:
    """The rows as a JSON list."""
    return msgspec.json.format(msgspec.json.encode([row.as_data() for row in rows]), indent=1)


def as_csv(rows: Sequence[Row]) -> str:
    """The rows as comma-separated values, a column a case key."""
    keys = list(dict.fromkeys(key for row in rows for key in row.case))
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*keys, "reading", "metric", *_FIGURES])
    for row in rows:
        data = row.as_data()
        figures = ("" if data[name] is None else data[name] for name in _FIGURES)
        cells = (_cell(row.case.get(key, "")) for key in keys)
        writer.writerow([*cells, row.reading or "", row.metric, *figures])
    return out.getvalue()


def show(outcome: Outcome, console: Console) -> None:
    """The table on a console."""
    header, lines = _table(outcome)
    table = Table(box=None, padding=(0, 1), header_style="bold", title=_title(outcome))
    keys = len(header) - _NUMBERS - 1
    for place, name in enumerate(header):
        side: Literal["left", "right"] = "left" if place <= keys else "right"
        table.add_column(name, justify=side, no_wrap=True)
    before: list[str] = []
    for line in lines:
        again = line[:keys] == before
        table.add_row(*([""] * keys if again else line[:keys]), *line[keys:])
        before = line[:keys]
    console.print(table)
    for remark in _remarks(outcome):
        console.print(f"* {remark}", highlight=False, markup=False)


def write(outcome: Outcome, folder: Path, command: str) -> list[Path]:
    """NAME.json, NAME.csv, NAME.png and NAME.md in ``folder``; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    name = outcome.experiment.name
    paths = {kind: folder / f"{name}.{kind}" for kind in ("json", "csv", "png", "md")}
    paths["json"].write_bytes(as_json(outcome.rows) + b"\n")
    paths["csv"].write_text(as_csv(outcome.rows))
    if outcome.experiment.plot is None:
        del paths["png"]
    else:
        _draw(outcome, paths["png"])
    paths["md"].write_text(as_markdown(outcome, command))
    return list(paths.values())


def as_markdown(outcome: Outcome, command: str) -> str:
    """A page with command, table, remarks and picture."""
    experiment = outcome.experiment
    header, lines = _table(outcome)
    text = [
        f"# {experiment.name}",
        f"{experiment.summary} ({experiment.source}).",
        f"    {command}",
    ]
    text.append("\n".join([_line(header), _line(["---"] * len(header)), *map(_line, lines)]))
    remarks = _remarks(outcome)
    if remarks:
        text.append("\n".join(f"- {remark}" for remark in remarks))
    if experiment.plot is not None:
        text.append(f"![{experiment.summary}]({experiment.name}.png)")
    return "\n\n".join(text) + "\n"


def number(value: float | None) -> str:
    """A figure in as many digits as it deserves."""
    if value is None or not math.isfinite(value):
        return "-"
    if value == round(value) and abs(value) < 1e6:
        return f"{value:.0f}"
    return f"{value:.4g}" if abs(value) < 10 else f"{value:.2f}"


def _remarks(outcome: Outcome) -> list[str]:
    experiment = outcome.experiment
    own = () if experiment.remarks is None else experiment.remarks(outcome)
    return [*own, *printed.load(experiment.printed).remarks]


def _title(outcome: Outcome) -> str:
    experiment = outcome.experiment
    return (
        f"{experiment.name}: {experiment.source}; {outcome.runs} runs a case, "
        f"seed {outcome.seed}, {outcome.fidelity}"
    )


def _table(outcome: Outcome) -> tuple[list[str], list[list[str]]]:
    """Header and cells; the last four columns are numbers. Curves are left out."""
    axis = outcome.experiment.axis
    rows = [row for row in outcome.rows if axis is None or axis.name not in row.case]
    rows = rows or list(outcome.rows)
    keys = list(dict.fromkeys(key for row in rows for key in row.case))
    readings = any(row.reading is not None for row in rows)
    header = [*keys, *(["reading"] if readings else []), "metric"]
    spread = "95 % interval" if outcome.experiment.intervals else "± se, or quartiles"
    header += ["paper", "ours", spread, "n"]
    return header, [_cells(row, keys, readings, outcome) for row in rows]


def _cells(row: Row, keys: Sequence[str], readings: bool, outcome: Outcome) -> list[str]:
    cells = [_cell(row.case.get(key, "")) for key in keys]
    if readings:
        cells.append(row.reading or "")
    of_all = f"{row.n}" if row.n == outcome.runs else f"{row.n}/{outcome.runs}"
    cells += [row.metric, number(row.paper)]
    if row.metric in outcome.experiment.medians:
        return [*cells, number(row.median), f"{number(row.q25)} .. {number(row.q75)}", of_all]
    if outcome.experiment.intervals:
        return [*cells, number(row.mean), _interval(row), of_all]
    return [*cells, number(row.mean), f"± {number(row.se)}", of_all]


def _interval(row: Row) -> str:
    """The 95 % interval of the mean."""
    if row.mean is None or row.se is None:
        return "-"
    wide = row.se * t_quantile(row.n - 1)
    return f"{number(row.mean - wide)} .. {number(row.mean + wide)}"


def _cell(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _draw(outcome: Outcome, path: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    figure = Figure(layout="constrained")
    assert outcome.experiment.plot is not None
    with mpl.rc_context({"font.size": 9.0, "axes.titlesize": 9.5}):
        outcome.experiment.plot(figure, outcome)
        figure.savefig(path, dpi=110, metadata={"Software": None})
