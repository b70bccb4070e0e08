"""``uavbridge monitor``: watch a mission that flies, here or elsewhere."""

from __future__ import annotations

import os
from typing import Any

import click

from uavbridge.agent.orders import Verb
from uavbridge.cli.command import ROUTER, choose_mission


@click.command()
@click.option("--mission", metavar="NAME", help="Which, if more than one flies.")
@click.option("--router", metavar="ENDPOINT", default=ROUTER, show_default=True, help="Of the bus.")
def monitor(**options: Any) -> None:
    """Watch a flying mission in the terminal: agents, merged map, events; keys give orders.

    It only listens, so it may join and leave at any time.
    """
    from rich.console import Console

    from uavbridge.bus.zenoh_bus import ZenohBus, find_missions
    from uavbridge.command import send_order
    from uavbridge.monitor.terminal import run
    from uavbridge.monitor.watch import MissionWatch

    router = options["router"]
    mission = choose_mission(find_missions(router), options["mission"], router)
    with ZenohBus(router, mission) as bus:
        watch = MissionWatch(bus)

        def send(verb: Verb, agent: int | None) -> str:
            replies = send_order(
                bus,
                verb,
                agents=tuple(sorted(watch.agents)) if agent is None else (agent,),
                everyone=agent is None,
                name=os.urandom(8).hex(),
                timeout_s=2.0,
            )
            refused = [f"agent {r.agent}: {r.reason}" for r in replies if not r.ok]
            done = f"{verb.value}: {len(replies) - len(refused)} of {len(replies)} done"
            return "; ".join([done, *refused])

        run(watch, send, Console())
