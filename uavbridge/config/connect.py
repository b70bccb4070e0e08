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
    free = [member.id for member in mission.team() if mission.endpoint(member.id) is None]
    if len(urls) > len(free):
        raise ConfigError(f"--connect: {len(urls)} URLs for {len(free)} agents without a vehicle")
    connected = with_endpoints(mission, dict(zip(free, urls, strict=False)))
    agents = [
        {key: value for key, value in to_builtins(agent).items() if value is not None}
        for agent in connected.agents
    ]
    return override(mission, {"agents": agents}, planners=planners)


def with_endpoints(mission: Mission, endpoints: Mapping[int, str]) -> Mission:
    """The mission with the vehicles of some of its team elsewhere, not checked again.

    Args:
        mission: checked.
        endpoints: where they are, by agent.
    """
    listed = {agent.id: agent for agent in mission.agents[: mission.vehicles]}
    for number, url in endpoints.items():
        listed[number] = replace(listed.get(number, Agent(id=number)), endpoint=url)
    return replace(mission, agents=tuple(listed.values()))
