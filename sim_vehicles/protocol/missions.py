"""The mission protocol: upload, download, clear, current; missions, fences and rally points.

Rule 1: while an upload runs the vehicle asks, and asks again for what does not come.
Rule 2: an upload that falls silent is given up; the stored items stay as they were.
Rule 3: a download is stateless: every request is answered for itself.
"""

from __future__ import annotations

from math import nan
from typing import Final

from sim_vehicles.codec import Packet, mav
from sim_vehicles.geodesy import to_geodetic
from sim_vehicles.protocol.endpoint import Endpoint, Upload
from sim_vehicles.protocol.fence import fence
from sim_vehicles.protocol.items import Item, place, plan, why_not

_TYPES: Final[tuple[int, ...]] = (
    mav.MAV_MISSION_TYPE_MISSION,
    mav.MAV_MISSION_TYPE_FENCE,
    mav.MAV_MISSION_TYPE_RALLY,
)
_TOTALS: Final[dict[int, str]] = {
    mav.MAV_MISSION_TYPE_MISSION: "MIS_TOTAL",
    mav.MAV_MISSION_TYPE_FENCE: "FENCE_TOTAL",
    mav.MAV_MISSION_TYPE_RALLY: "RALLY_TOTAL",
}
"""Parameters that hold how many items there are, where the autopilot has them."""
_ALL: Final[int] = mav.MAV_MISSION_TYPE_ALL
_GUIDED: Final = 2  # in ``current``
_MOST: Final = 2000  # items of one type
_ASK_AGAIN_US: Final = 250_000
_GIVE_UP_US: Final = 5_000_000
_WARNING: Final = 4


def on_count(endpoint: Endpoint, packet: Packet) -> None:
    """MISSION_COUNT: an upload begins."""
    message, peer = packet.message, (packet.system, packet.component)
    kind = message.mission_type
    running = endpoint.upload
    if kind not in _TYPES:
        _ack(endpoint, peer, mav.MAV_MISSION_UNSUPPORTED, kind)
    elif running is not None and running.peer != peer:
        _ack(endpoint, peer, mav.MAV_MISSION_DENIED, kind)
    elif message.count > _MOST:
        _ack(endpoint, peer, mav.MAV_MISSION_NO_SPACE, kind)
    elif message.count == 0:
        endpoint.upload = None
        _ack(endpoint, peer, _store(endpoint, kind, ()), kind)
    else:
        now = endpoint.now_us
        endpoint.upload = Upload(peer, kind, message.count, [], now, now)
        endpoint.uploaded = None
        endpoint.busy = True
        _ask(endpoint, endpoint.upload)


def on_item(endpoint: Endpoint, packet: Packet) -> None:
    """MISSION_ITEM_INT or MISSION_ITEM: the one asked for is taken, others are not."""
    message, peer = packet.message, (packet.system, packet.component)
    upload = endpoint.upload
    if endpoint.services.flavour.home_first and message.current == _GUIDED:
        _ack(endpoint, peer, _go_there(endpoint, Item.read(message)), message.mission_type)
        return
    if upload is None:
        # our last acknowledgement was lost
        if endpoint.uploaded == (peer, message.mission_type, message.seq + 1):
            _ack(endpoint, peer, mav.MAV_MISSION_ACCEPTED, message.mission_type)
        return
    if peer != upload.peer or message.mission_type != upload.mission_type:
        return
    upload.heard_us = endpoint.now_us
    if message.seq != len(upload.items):
        return  # one we have, or one too early: the timer asks again
    item = Item.read(message)
    home_first = endpoint.services.flavour.home_first
    result = why_not(item, upload.mission_type, any_frame=home_first)
    if result != mav.MAV_MISSION_ACCEPTED:
        endpoint.upload = None
        _ack(endpoint, peer, result, upload.mission_type)
        return
    upload.items.append(item)
    if len(upload.items) < upload.count:
        _ask(endpoint, upload)
        return
    endpoint.upload = None
    result = _store(endpoint, upload.mission_type, tuple(upload.items))
    if result == mav.MAV_MISSION_ACCEPTED:
        endpoint.uploaded = peer, upload.mission_type, upload.count
    _ack(endpoint, peer, result, upload.mission_type)


def _go_there(endpoint: Endpoint, item: Item) -> int:
    """An item that is no part of a mission, but a place for ArduPilot's Guided mode."""
    pilot, i, origin = endpoint.pilot, endpoint.index, endpoint.services.origin
    result = why_not(item, int(mav.MAV_MISSION_TYPE_MISSION), any_frame=True)
    if result != mav.MAV_MISSION_ACCEPTED:
        return result
    there = place(item, origin, float(pilot.status.home[i, 2]))
    refusal = pilot.reposition(i, there, nan, may_change=False)
    return int(mav.MAV_MISSION_ACCEPTED if refusal is None else mav.MAV_MISSION_ERROR)


def go_on(endpoint: Endpoint) -> bool:
    """Ask again, or give up; whether an upload still runs."""
    upload = endpoint.upload
    if upload is None:
        return False
    if endpoint.now_us - upload.heard_us >= _GIVE_UP_US:
        endpoint.upload = None
        endpoint.say(_WARNING, "Mission upload timed out")
        _ack(endpoint, upload.peer, mav.MAV_MISSION_OPERATION_CANCELLED, upload.mission_type)
        return False
    if endpoint.now_us - upload.asked_us >= _ASK_AGAIN_US:
        _ask(endpoint, upload)
    return True


def on_ack(endpoint: Endpoint, packet: Packet) -> None:
    """MISSION_ACK: the end of a download, or the sender calls its upload off."""
    upload = endpoint.upload
    if upload is None or upload.peer != (packet.system, packet.component):
        return
    if packet.message.type != mav.MAV_MISSION_ACCEPTED:
        endpoint.upload = None


def on_request_list(endpoint: Endpoint, packet: Packet) -> None:
    """MISSION_REQUEST_LIST: how many there are."""
    kind = packet.message.mission_type
    if kind not in _TYPES:
        _ack(endpoint, (packet.system, packet.component), mav.MAV_MISSION_UNSUPPORTED, kind)
        return
    endpoint.send(
        "MISSION_COUNT",
        count=len(endpoint.stored.get(kind, ())),
        mission_type=kind,
        target_system=packet.system,
        target_component=packet.component,
    )


def on_request(endpoint: Endpoint, packet: Packet) -> None:
    """MISSION_REQUEST_INT or MISSION_REQUEST: one item, in the form asked for."""
    message = packet.message
    items = endpoint.stored.get(message.mission_type, ())
    if message.seq >= len(items):
        peer = packet.system, packet.component
        _ack(endpoint, peer, mav.MAV_MISSION_INVALID_SEQUENCE, message.mission_type)
        return
    item = items[message.seq]
    if message.seq == 0 and message.mission_type == mav.MAV_MISSION_TYPE_MISSION:
        item = _first(endpoint, item)
    fields = item._asdict()
    if message.msgname == "MISSION_REQUEST":
        fields |= {"x": item.x * 1e-7, "y": item.y * 1e-7}
    endpoint.send(
        "MISSION_ITEM_INT" if message.msgname == "MISSION_REQUEST_INT" else "MISSION_ITEM",
        seq=message.seq,
        mission_type=message.mission_type,
        target_system=packet.system,
        target_component=packet.component,
        **fields,
    )


def _first(endpoint: Endpoint, item: Item) -> Item:
    """The first item of a mission: where home is now, for an autopilot that keeps it there."""
    if not endpoint.services.flavour.home_first:
        return item
    home = endpoint.pilot.status.home[endpoint.index]
    latitude, longitude, altitude = to_geodetic(home, endpoint.services.origin)
    return item._replace(
        frame=int(mav.MAV_FRAME_GLOBAL),
        command=int(mav.MAV_CMD_NAV_WAYPOINT),
        x=round(float(latitude) * 1e7),
        y=round(float(longitude) * 1e7),
        z=float(altitude),
    )


def on_clear(endpoint: Endpoint, packet: Packet) -> None:
    """MISSION_CLEAR_ALL, of one type or of all."""
    kind, peer = packet.message.mission_type, (packet.system, packet.component)
    if kind != _ALL and kind not in _TYPES:
        _ack(endpoint, peer, mav.MAV_MISSION_UNSUPPORTED, kind)
        return
    for each in _TYPES if kind == _ALL else (kind,):
        _store(endpoint, each, ())
    endpoint.upload = None
    _ack(endpoint, peer, mav.MAV_MISSION_ACCEPTED, kind)


def on_set_current(endpoint: Endpoint, packet: Packet) -> None:
    """MISSION_SET_CURRENT: answered with MISSION_CURRENT."""
    pilot, i, services = endpoint.pilot, endpoint.index, endpoint.services
    if packet.message.seq >= len(pilot.plans[i].steps):
        endpoint.say(_WARNING, f"Mission has no item {packet.message.seq}")
        return
    pilot.set_current(i, packet.message.seq)
    services.report.plan(i)
    endpoint.show("MISSION_CURRENT")


def on_partial(endpoint: Endpoint, packet: Packet) -> None:
    """Partial lists are refused: PX4 has none."""
    peer = packet.system, packet.component
    _ack(endpoint, peer, mav.MAV_MISSION_UNSUPPORTED, packet.message.mission_type)


def _store(endpoint: Endpoint, kind: int, items: tuple[Item, ...]) -> int:
    """Take items in; MAV_MISSION_RESULT."""
    services, pilot, i = endpoint.services, endpoint.pilot, endpoint.index
    home_z = float(pilot.status.home[i, 2])
    if kind == mav.MAV_MISSION_TYPE_MISSION:
        first = services.flavour.home_first
        steps = plan(items, services.origin, home_z, home_first=first)
        if steps is None:
            return int(mav.MAV_MISSION_INVALID_PARAM1)
        pilot.load(i, steps)
        services.report.plan(i)
    elif kind == mav.MAV_MISSION_TYPE_FENCE:
        pilot.failsafes.fences.pop(i, None)
        if items:
            allowed = fence(items, services.origin)
            if allowed is None:
                return int(mav.MAV_MISSION_INVALID)
            pilot.failsafes.fences[i] = allowed
    else:
        pilot.rallies[i] = tuple(place(item, services.origin, home_z) for item in items)
    endpoint.stored[kind] = items
    total = _TOTALS[kind]
    if pilot.parameters.row(total) is not None:
        pilot.parameters.set(i, total, min(len(items), 100))
    return int(mav.MAV_MISSION_ACCEPTED)


def _ask(endpoint: Endpoint, upload: Upload) -> None:
    upload.asked_us = endpoint.now_us
    system, component = upload.peer
    endpoint.send(
        endpoint.services.flavour.answers.asks_for,
        seq=len(upload.items),
        mission_type=upload.mission_type,
        target_system=system,
        target_component=component,
    )


def _ack(endpoint: Endpoint, peer: tuple[int, int], result: int, kind: int) -> None:
    endpoint.send(
        "MISSION_ACK",
        type=result,
        mission_type=kind,
        target_system=peer[0],
        target_component=peer[1],
    )
