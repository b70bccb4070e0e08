"""The link itself: who is there, and what time it is."""

from __future__ import annotations

from sim_vehicles.codec import Packet, mav
from sim_vehicles.protocol.endpoint import Endpoint


def on_heartbeat(endpoint: Endpoint, packet: Packet) -> None:
    """HEARTBEAT: ground stations are missed when they fall silent."""
    if packet.message.type == mav.MAV_TYPE_GCS:
        endpoint.pilot.heard_gcs(endpoint.index)


def on_timesync(endpoint: Endpoint, packet: Packet) -> None:
    """TIMESYNC request: the vehicle's time since start, ns, beside the sender's."""
    if packet.message.tc1 == 0:
        endpoint.send("TIMESYNC", tc1=endpoint.now_us * 1000, ts1=packet.message.ts1)


def on_ping(endpoint: Endpoint, packet: Packet) -> None:
    """PING to everyone is answered; answers are not."""
    message = packet.message
    if message.target_system == 0 and message.target_component == 0:
        endpoint.send(
            "PING",
            time_usec=message.time_usec,
            seq=message.seq,
            target_system=packet.system,
            target_component=packet.component,
        )
