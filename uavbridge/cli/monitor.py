"""``uavbridge monitor``: watch a mission that flies, here or elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from uavbridge.cli.command import KEYS, ROUTER, choose_mission, identity_of
from uavbridge.cli.steps import steps

if TYPE_CHECKING:
    from uavbridge.monitor.replayed import Player
    from uavbridge.monitor.source import Source


@click.command()
@click.argument("recording", type=click.Path(path_type=Path), required=False)
@click.option("--web", is_flag=True, help="In the browser; prints the page's address.")
@click.option("--port", type=int, default=8000, show_default=True, help="Of the page; 0: any.")
@click.option("--host", default="127.0.0.1", show_default=True, help="Address of the page.")
@click.option("--token", envvar="UAVBRIDGE_TOKEN", metavar="T", help="Asked of who opens the page.")
@click.option("--mission", metavar="NAME", help="Which, if more than one flies.")
@click.option("--router", metavar="ENDPOINT", default=ROUTER, show_default=True, help="Of the bus.")
@KEYS
def monitor(recording: Path | None, **options: Any) -> None:
    """Watch a flying mission: agents, merged map, events; keys give orders.

    It only listens, so it may join and leave at any time. With a RECORDING (mission.mcap, or its
    folder) watch that: pause, speed, back and forth. With --web in the browser.
    """
    if options["web"]:
        _in_browser(recording, options)
    elif recording is not None:
        from uavbridge.monitor.source import Recorded

        _show(Recorded(_player(recording)))
    else:
        from uavbridge.bus.zenoh_bus import ZenohBus, find_missions
        from uavbridge.monitor.source import Live

        router, identity = options["router"], identity_of(options["keys"])
        found = find_missions(router, identity=identity)
        mission = choose_mission(found, options["mission"], router)
        with ZenohBus(router, mission, identity=identity) as bus:
            _show(Live(bus, mission))


def _show(source: Source) -> None:
    from rich.console import Console

    from uavbridge.monitor.terminal import run
    from uavbridge.runner.interrupts import interrupts

    with interrupts() as stop:
        run(source, Console(), stop)


def _player(recording: Path) -> Player:
    from uavbridge.monitor.replayed import Player

    with steps("reading") as tell:
        return Player(recording, tell)


def _in_browser(recording: Path | None, options: dict[str, Any]) -> None:
    from uavbridge.bus.zenoh_bus import find_missions
    from uavbridge.monitor.web.pages import Place, check, serve_live, serve_recording

    place = Place(options["host"], options["port"], options["token"])
    check(place)

    def ready(address: str) -> None:
        click.echo(f"{address}  (Ctrl-C ends)")

    if recording is not None:
        serve_recording(_player(recording), place, ready)
        return
    router, identity = options["router"], identity_of(options["keys"])
    mission = choose_mission(find_missions(router, identity=identity), options["mission"], router)
    serve_live(router, mission, place, ready, identity=identity)
