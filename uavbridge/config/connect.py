"""``--connect``: endpoints for the agents of a mission, in order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec import to_builtins
from msgspec.structs import replace

from planners.planner import PlannerKind
from uavbridge.config.load import override
from uavbridge.config.mission import Mission
from uavbridge.config.tables import Agent
from uavbridge.errors import ConfigError
from uavbridge.mavlink.urls import parse_url


def connect(
    mission: Mission,
    urls: Sequence[str],
    *,
    planners: Mapping[str, PlannerKind] | None = None,
) -> Mission:
    """The mission with a vehicle elsewhere for each URL.

    Args:
        mission: checked.
        urls: fill the agents that have no endpoint yet, by ascending id; as many as given.
        planners: as in ``load``.

    Raises:
        ConfigError: a URL is wrong, or there are more than agents.
    """
    for url in urls:
        try:
            parse_url(url)
        except ConfigError as error:
            raise error.at("--connect") from None
    if not urls:
        return mission
    listed = {agent.id: agent for agent in mission.agents[: mission.vehicles]}
    free = [member.id for member in mission.team() if mission.endpoint(member.id) is None]
    if len(urls) > len(free):
        raise ConfigError(f"--connect: {len(urls)} URLs for {len(free)} agents without a vehicle")
    for number, url in zip(free, urls, strict=False):
        listed[number] = replace(listed.get(number, Agent(id=number)), endpoint=url)
    agents = [
        {key: value for key, value in to_builtins(agent).items() if value is not None}
        for agent in listed.values()
    ]
    return override(mission, {"agents": agents}, planners=planners)
