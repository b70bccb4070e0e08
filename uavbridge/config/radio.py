"""The radio that a mission file asks for."""

from __future__ import annotations

from collections.abc import Collection

from uavbridge.config.field_error import FieldError
from uavbridge.config.mission import Mission
from uavbridge.radio import Link, Quality, Radio


def radio_of(mission: Mission) -> Radio:
    """The links between the agents of a mission.

    Raises:
        ValueError: the numbers of a link do not fit together.
    """
    table = mission.radio
    quality = Quality(
        range_m=table.range_m,
        loss=table.loss,
        burst_enter=table.burst_enter,
        burst_leave=table.burst_leave,
        burst_loss=table.burst_loss,
        delay_s=table.delay_s,
        jitter_s=table.jitter_s,
        bytes_per_s=table.bytes_per_s,
        queue_s=table.queue_s,
    )
    links = tuple(
        Link(
            link.sender,
            link.receiver,
            link.range_m,
            link.loss,
            link.burst_enter,
            link.burst_leave,
            link.burst_loss,
            link.delay_s,
            link.jitter_s,
            link.bytes_per_s,
        )
        for link in table.links
    )
    return Radio(table.range_m, mission.seed, quality, links)


def check_radio(mission: Mission, team: Collection[int]) -> None:
    """Hold the radio's numbers against each other and the team's ids. Raises FieldError."""
    table = mission.radio
    if table.burst_enter and not 0.0 < table.burst_leave <= 1.0 - table.burst_enter:
        what = f"must be above 0 and at most 1 - burst_enter = {1.0 - table.burst_enter:g}"
        raise FieldError(("radio", "burst_leave"), what, table.burst_leave)
    for index, link in enumerate(table.links):
        for key, agent in (("from", link.sender), ("to", link.receiver)):
            if agent is not None and agent not in team:
                raise FieldError(("radio", "links", index, key), "there is no such agent", agent)
    try:
        radio_of(mission)
    except ValueError as error:
        raise FieldError(("radio", "links"), str(error)) from None
