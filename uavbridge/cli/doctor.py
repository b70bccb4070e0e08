"""``uavbridge doctor``: look before flying."""

from __future__ import annotations

from typing import Any

import click

from uavbridge.cli.group import echo_json
from uavbridge.cli.mission import connecting, load, overrides
from uavbridge.cli.numbers import NOT_NEGATIVE


@click.command()
@click.argument("mission", type=click.Path(dir_okay=True), required=False)
@overrides
@connecting
@click.option("--wait", type=NOT_NEGATIVE, default=10.0, show_default=True, help="For vehicles, s.")
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
@click.pass_context
def doctor(
    ctx: click.Context,
    /,
    mission: str | None,
    connect: tuple[str, ...],
    wait: float,
    as_json: bool,
    **options: Any,
) -> None:
    """Look at all that a launch of MISSION needs, and say what to do.

    Ports, vehicles and what they wait for, ids, parameters that will bite, router, clocks,
    versions. Nothing is commanded. Exit status: 0 only if the mission could fly now, 1 when
    not, 2 for bad input.
    """
    loaded = load(mission, connect, options)
    from uavbridge.doctor import examine

    diagnosis = examine(
        loaded,
        adopt_home=mission is None and bool(connect),
        adopt_speed=options["speed"] is None,
        wait_s=wait,
    )
    if as_json:
        echo_json(diagnosis)
    else:
        click.echo("\n".join(diagnosis.lines()))
    ctx.exit(0 if diagnosis.ready else 1)
