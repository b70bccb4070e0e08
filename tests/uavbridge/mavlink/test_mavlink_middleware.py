"""Links that wrap links, and connection strings."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_vehicles.codec import Encoder
from uavbridge.errors import ConfigError
from uavbridge.mavlink.link import memory_pair
from uavbridge.mavlink.middleware import LossyLink, TlogLink
from uavbridge.mavlink.texts import Texts
from uavbridge.mavlink.urls import Endpoint, parse_url
from uavbridge.rng import stream


def test_every_datagram_is_shown_with_its_time() -> None:
    here, there = memory_pair()
    shown: list[tuple[int, str, bytes]] = []
    now_us = 5
    link = TlogLink(here, lambda *datagram: shown.append(datagram), lambda: now_us)
    encoder = Encoder(1)
    a, b, c = (encoder.pack("HEARTBEAT", custom_mode=number) for number in (1, 2, 3))
    link.send(a + b)
    now_us = 9
    there.send(c + b"junk")
    assert link.receive() == [c + b"junk"]
    assert there.receive() == [a + b]
    assert shown == [(5, "sent", a + b), (9, "received", c + b"junk")]


@given(st.floats(0.0, 1.0), st.integers(0, 100))
def test_loss_is_as_often_as_asked_and_the_same_again(loss: float, seed: int) -> None:
    def survivors() -> list[bytes]:
        here, there = memory_pair()
        link = LossyLink(here, loss, stream(seed, "loss"))
        for number in range(200):
            there.send(bytes([number]))
        return link.receive()

    heard = survivors()
    assert heard == survivors()
    assert len(heard) == pytest.approx(200 * (1 - loss), abs=40)
    assert heard == sorted(heard)


def test_loss_both_ways_and_out_of_range() -> None:
    here, there = memory_pair()
    link = LossyLink(here, 1.0, np.random.default_rng(0))
    link.send(b"x")
    there.send(b"y")
    assert there.receive() == []
    assert link.receive() == []
    assert link.dropped == 2
    with pytest.raises(ValueError, match=r"loss must be 0\.\.1, not 1\.5"):
        LossyLink(here, 1.5, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("url", "endpoint"),
    [
        ("udpin:127.0.0.1:14540", Endpoint("udpin", "127.0.0.1", 14540)),
        ("udp:0.0.0.0:14550", Endpoint("udpin", "0.0.0.0", 14550)),
        ("udpin://127.0.0.1:14541", Endpoint("udpin", "127.0.0.1", 14541)),
        ("udp://:14540", Endpoint("udpin", "0.0.0.0", 14540)),
        ("udpin://0.0.0.0", Endpoint("udpin", "0.0.0.0", 14540)),
        ("udpout:10.0.0.2:14580", Endpoint("udpout", "10.0.0.2", 14580)),
        ("udpout://10.0.0.2:14580", Endpoint("udpout", "10.0.0.2", 14580)),
        ("tcp:localhost:5760", Endpoint("tcp", "localhost", 5760)),
        ("tcpout://10.0.0.2", Endpoint("tcp", "10.0.0.2", 5760)),
        ("UDPIN:127.0.0.1:0", Endpoint("udpin", "127.0.0.1", 0)),
        ("tcpin:0.0.0.0:5760", Endpoint("tcpin", "0.0.0.0", 5760)),
        ("tcpin://:5761", Endpoint("tcpin", "0.0.0.0", 5761)),
        ("mcast:", Endpoint("mcast", "239.255.145.50", 14550)),
        ("mcast:14560", Endpoint("mcast", "239.255.145.50", 14560)),
        ("mcast:239.1.2.3:9000", Endpoint("mcast", "239.1.2.3", 9000)),
        ("/dev/ttyUSB0,115200", Endpoint("serial", "/dev/ttyUSB0", baud=115200)),
        ("/dev/ttyACM0", Endpoint("serial", "/dev/ttyACM0", baud=57600)),
        ("serial:/dev/ttyUSB0:57600", Endpoint("serial", "/dev/ttyUSB0", baud=57600)),
        ("serial:///dev/ttyAMA0:921600", Endpoint("serial", "/dev/ttyAMA0", baud=921600)),
        ("udpin:0.0.0.0:14549#12", Endpoint("udpin", "0.0.0.0", 14549, system=12)),
    ],
)
def test_both_spellings(url: str, endpoint: Endpoint) -> None:
    assert parse_url(url) == endpoint
    assert parse_url(str(endpoint)) == endpoint


@pytest.mark.parametrize(
    ("url", "word"),
    [
        ("", "unknown kind"),
        ("127.0.0.1:14540", "unknown kind"),
        ("serial:/dev/ttyUSB0:57601", "no baud rate"),
        ("serial:ttyUSB0:57600", "no device"),
        ("mcast:10.0.0.1:14550", "no multicast group"),
        ("udpin:127.0.0.1:14550#0", "system id"),
        ("udpin:127.0.0.1:14550#seven", "system id"),
        ("udpin:127.0.0.1", "port"),
        ("udpin:127.0.0.1:x", "port"),
        ("udpin:127.0.0.1:70000", "port"),
        ("udpin:127.0.0.1:-1", "port"),
        ("udpin:127.0.0.1:" + "1" * 5000, "port"),
        ("udpout::14540", "needs a host"),
        ("tcp://10.0.0.2:0", "needs a host and a port"),
        ("udpin:::1:14540", "IPv4"),
    ],
)
def test_a_wrong_string_is_named(url: str, word: str) -> None:
    with pytest.raises(ConfigError, match=word) as caught:
        parse_url(url)
    assert repr(url) in str(caught.value)


@given(st.text(max_size=40))
def test_any_string_is_an_endpoint_or_a_config_error(url: str) -> None:
    try:
        endpoint = parse_url(url)
    except ConfigError:
        return
    assert 0 <= endpoint.port <= 65535


def text(number: int, chunk: int, words: str) -> object:
    return SimpleNamespace(severity=6, id=number, chunk_seq=chunk, text=words)


def test_long_texts_are_joined() -> None:
    texts = Texts()
    head = "RTL: start return at 520 m (30 m above destination"
    assert texts.hear(text(0, 0, "short\t"), 1) == [(6, "short")]
    assert texts.hear(text(4, 0, head), 1) == []
    assert texts.hear(text(4, 0, head), 1) == []
    assert texts.hear(text(4, 1, ")\t"), 1) == [(6, head + ")")]
    assert texts.hear(text(4, 1, ")\t"), 1) == []


def test_a_text_whose_end_is_lost_is_told_with_the_next() -> None:
    texts = Texts()
    assert texts.hear(text(1, 1, "b" * 50), 1) == []
    assert texts.hear(text(2, 0, "next"), 1) == [(6, "[...]" + "b" * 50), (6, "next")]
