"""Links over real sockets on loopback."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Iterator

import pytest

from sim_vehicles.codec import Encoder
from tests.integration.simulator import free_port
from uavbridge.clock import wall_s
from uavbridge.errors import LinkError
from uavbridge.mavlink.hub import Hub
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.tcp import TcpLink
from uavbridge.mavlink.udp import UdpGate, UdpLink
from uavbridge.mavlink.urls import open_hub, open_link, parse_url

pytestmark = pytest.mark.integration
LOCALHOST = "127.0.0.1"


def frame(system: int, number: int = 0) -> bytes:
    return Encoder(system).pack("HEARTBEAT", custom_mode=number, mavlink_version=3)


def until(condition: Callable[[], bool], limit_s: float = 5.0) -> None:
    """Poll: loopback delivers soon, but not at once."""
    end = wall_s() + limit_s
    while not condition():
        assert wall_s() < end, "nothing came in time"


def gather(link: Link, count: int) -> list[bytes]:
    heard: list[bytes] = []

    def enough() -> bool:
        heard.extend(link.receive())
        return len(heard) >= count

    until(enough)
    return heard


@pytest.fixture
def speaker() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.bind((LOCALHOST, 0))
        opened.settimeout(5.0)
        yield opened


def test_a_bound_link_answers_to_whom_it_hears(speaker: socket.socket) -> None:
    link = UdpLink.bind(LOCALHOST, 0)
    link.send(b"to nobody")
    assert link.lost == 1
    assert link.receive() == []
    speaker.sendto(frame(1), (LOCALHOST, link.port))
    assert gather(link, 1) == [frame(1)]
    link.send(b"answer")
    assert speaker.recv(100) == b"answer"
    link.close()


def test_a_peer_that_moves_is_followed_and_two_peers_are_rivals(speaker: socket.socket) -> None:
    link = UdpLink.bind(LOCALHOST, 0)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind((LOCALHOST, 0))
        for opened in (speaker, other):
            opened.sendto(frame(1), (LOCALHOST, link.port))
            gather(link, 1)
        assert link.peer.address == other.getsockname()
        assert link.peer.rivals == frozenset()
        speaker.sendto(frame(1), (LOCALHOST, link.port))
        gather(link, 1)
        assert link.peer.rivals == {speaker.getsockname(), other.getsockname()}
    link.close()


def test_garbage_and_strangers_draw_no_answers_to_themselves(speaker: socket.socket) -> None:
    link = UdpLink.bind(LOCALHOST, 0, 1)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind((LOCALHOST, 0))
        there = (LOCALHOST, link.port)
        bad = bytearray(frame(1))
        bad[-1] ^= 1
        for data in (b"x", bytes(bad), frame(1)[:-3], b"", frame(2)):
            other.sendto(data, there)
        gather(link, 5)
        assert link.peer.address is None
        speaker.sendto(frame(1), there)
        gather(link, 1)
        for data in (b"x", bytes(bad), frame(2)):
            other.sendto(data, there)
        gather(link, 3)
        link.send(b"answer")
        assert speaker.recv(100) == b"answer"
    link.close()


def test_a_connecting_link_survives_that_nobody_is_there(speaker: socket.socket) -> None:
    port = speaker.getsockname()[1]
    link = open_link(f"udpout:{LOCALHOST}:{port}")
    link.send(b"one")
    assert speaker.recv(100) == b"one"
    speaker.close()
    for _ in range(10):
        link.send(b"two")
        assert link.receive() == []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again:
        again.bind((LOCALHOST, port))
        again.settimeout(5.0)
        link.send(b"three")
        link.send(b"three")
        assert again.recv(100) == b"three"
    link.close()


def test_a_port_in_use_is_named() -> None:
    link = UdpLink.bind(LOCALHOST, 0)
    with pytest.raises(LinkError, match=f"UDP port {link.port} on {LOCALHOST} is in use"):
        open_link(f"udpin:{LOCALHOST}:{link.port}")
    with pytest.raises(LinkError, match=f"UDP port {link.port} on {LOCALHOST} is in use"):
        Hub(UdpGate(LOCALHOST, link.port), "here")
    link.close()


def test_an_address_that_is_none_is_named() -> None:
    with pytest.raises(LinkError, match=r"UDP 203\.0\.113\.7:1"):
        open_link("udpin:203.0.113.7:1")


def test_a_hub_sorts_by_system(speaker: socket.socket) -> None:
    hub = Hub(UdpGate(LOCALHOST, 0), "here")
    one, two = hub.channel(1), hub.channel(2)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.settimeout(5.0)
        other.bind((LOCALHOST, 0))
        there = (LOCALHOST, hub.port)
        speaker.sendto(frame(1, 1) + frame(1, 2), there)
        other.sendto(frame(2, 3), there)
        other.sendto(frame(3, 4), there)
        other.sendto(b"noise", there)
        assert gather(two, 1) == [frame(2, 3)]
        until(lambda: not two.receive() and hub.noise == 1)
        assert one.receive() == [frame(1, 1) + frame(1, 2)]
        one.send(b"for one")
        two.send(b"for two")
        assert speaker.recv(100) == b"for one"
        assert other.recv(100) == b"for two"
        assert set(hub.peers) == {1, 2, 3}
        for _ in range(3):  # system 2 has moved, or has a twin: three in a row show which
            assert two.receive() == []
            speaker.sendto(frame(1, 5) + frame(2, 6) + frame(1, 7), there)
            assert gather(one, 1) == [frame(1, 5) + frame(1, 7)]
        assert two.receive() == [frame(2, 6)]
    with pytest.raises(LinkError, match="system 1 has a link already"):
        hub.channel(1)
    port = hub.port
    one.close()
    assert one.receive() == []
    one.send(b"late")
    assert one.lost == 1
    two.close()
    UdpLink.bind(LOCALHOST, port).close()  # the last channel has let go of the port


def test_a_stream_is_cut_into_frames_wherever_it_is_read() -> None:
    with socket.create_server((LOCALHOST, 0)) as server:
        link = TcpLink(LOCALHOST, server.getsockname()[1])
        peer, _ = server.accept()
        frames = [frame(1, number) for number in range(3)]
        heard: list[bytes] = []
        for byte in b"boot text " + b"".join(frames):
            peer.send(bytes([byte]))
            heard += link.receive()
        until(lambda: bool(heard.extend(link.receive())) or len(heard) == 3)
        assert heard == frames
        assert link.trouble == ""
        assert link.counts.noise == 10
        link.send(b"to you")
        assert peer.recv(100) == b"to you"
        peer.close()
        link.close()


def test_tcp_connects_again_by_itself() -> None:
    with socket.create_server((LOCALHOST, 0)) as server:
        port = server.getsockname()[1]
    link = TcpLink(LOCALHOST, port)

    def refused() -> bool:
        link.receive()
        return "refused" in link.trouble

    until(refused)
    assert str(port) in link.trouble
    link.send(b"lost")
    assert link.lost == 1
    with socket.create_server((LOCALHOST, port)) as server:
        server.setblocking(False)
        until(lambda: link.receive() == [] and link.trouble == "")
        server.setblocking(True)
        peer, _ = server.accept()
        peer.close()
        until(lambda: link.receive() == [] and link.trouble != "")
    link.close()
    assert link.receive() == []


def test_a_tcp_server_tells_its_clients_apart() -> None:
    hub = open_hub(parse_url(f"tcpin:{LOCALHOST}:0"))
    one, two = hub.channel(1), hub.channel(2)
    there = (LOCALHOST, hub.port)
    with socket.create_connection(there) as first, socket.create_connection(there) as second:
        first.sendall(frame(1, 1)[:5])
        second.sendall(frame(2, 2) + frame(2, 3))
        assert gather(two, 2) == [frame(2, 2), frame(2, 3)]
        first.sendall(frame(1, 1)[5:])
        assert gather(one, 1) == [frame(1, 1)]
        one.send(b"for one")
        two.send(b"for two")
        assert first.recv(100) == b"for one"
        assert second.recv(100) == b"for two"
        second.sendall(frame(1, 4))
        until(lambda: one.receive() == [] and not hub.peers[1].rivals)
        first.sendall(frame(1, 5))
        assert gather(one, 1) == [frame(1, 5)]  # the one that was there first is listened to
        assert hub.peers[1].rivals == {first.getsockname(), second.getsockname()}
        assert one.twins() == tuple(
            f"127.0.0.1:{p}" for p in sorted(each.getsockname()[1] for each in (first, second))
        )
    hub.close()


def test_multicast_hears_the_group_but_not_itself() -> None:
    group = f"mcast:239.255.145.51:{free_port()}"
    try:
        here, there = open_hub(parse_url(group)), open_hub(parse_url(group))
    except LinkError as error:
        pytest.skip(str(error))
    one, own = there.channel(1), here.channel(1)
    own.send(frame(1, 1))
    assert gather(one, 1) == [frame(1, 1)]
    assert own.receive() == []
    here.close()
    there.close()


def test_a_serial_device_is_read_and_written() -> None:
    far, near = os.openpty()
    device = os.ttyname(near)
    hub = open_hub(parse_url(f"serial:{device}:57600"))
    one = hub.channel(1)
    os.write(far, b"boot noise" + frame(1, 1) + frame(1, 2)[:4])
    assert gather(one, 1) == [frame(1, 1)]
    os.write(far, frame(1, 2)[4:])
    assert gather(one, 1) == [frame(1, 2)]
    one.send(frame(245, 3))
    assert os.read(far, 100) == frame(245, 3)
    os.close(far)
    os.close(near)
    until(lambda: one.receive() == [] and device in hub.trouble)
    hub.close()
    with pytest.raises(LinkError, match="serial /dev/no-such-device"):
        open_link("/dev/no-such-device,57600")
