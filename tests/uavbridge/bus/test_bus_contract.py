"""What every bus does, local or live."""

import time

import pytest

from tests.uavbridge.bus.sessions import PATIENCE_S, LocalSessions, Sessions, ZenohSessions
from uavbridge.bus.api import Sample
from uavbridge.errors import BusError


class Contract(Sessions):
    def test_another_session_and_the_own_one_hear_what_is_published(self) -> None:
        a, b = self.session(), self.session()
        here, there = a.subscribe("air/**"), b.subscribe("air/**")
        self.settle(a, a, b)
        a.publish("air/0/0/1", b"one")
        a.publish("air/0/0/2", b"two")
        expected = [Sample("air/0/0/1", b"one"), Sample("air/0/0/2", b"two")]
        assert self.collect(here, 2) == expected
        assert self.collect(there, 2) == expected

    def test_only_what_matches_is_collected(self) -> None:
        a, b = self.session(), self.session()
        box = b.subscribe("air/*/*/7")
        self.settle(a, b)
        for key in ("air/0/0/8", "safety/0/0/7", "air/0/7", "air/-1/3/7"):
            a.publish(key, b"x")
        self.settle(a, b)
        assert box.drain() == [Sample("air/-1/3/7", b"x")]

    def test_empty_and_large_data_survive(self) -> None:
        a, b = self.session(), self.session()
        box = b.subscribe("cmd/*")
        self.settle(a, b)
        large = bytes(range(256)) * 4096
        a.publish("cmd/1", b"")
        a.publish("cmd/1", large)
        assert [sample.data for sample in self.collect(box, 2)] == [b"", large]

    def test_a_closed_mailbox_keeps_what_it_had_and_collects_no_more(self) -> None:
        a, b = self.session(), self.session()
        box = b.subscribe("cmd/1")
        self.settle(a, b)
        a.publish("cmd/1", b"before")
        self.settle(a, b)
        box.close()
        box.close()
        a.publish("cmd/1", b"after")
        self.settle(a, b)
        assert [sample.data for sample in box.drain()] == [b"before"]
        assert box.drain() == []

    def test_query_finds_everybody_who_serves_a_matching_key(self) -> None:
        a, b, c = self.session(), self.session(), self.session()
        a.serve("state/1/map", lambda key: key.encode())
        b.serve("state/2/map", lambda key: key.encode())
        b.serve("state/3/map", lambda key: None)
        self.settle(a, c)
        self.settle(b, c)
        one, two = (Sample(f"state/{i}/map", f"state/{i}/map".encode()) for i in (1, 2))
        assert c.query("state/*/map") == [one, two]
        assert c.query("state/2/map") == [two]
        assert b.query("state/2/map") == [two]
        assert c.query("state/3/map") == []
        assert c.query("state/9/map") == []

    def test_tokens_are_seen_to_come_and_go(self) -> None:
        a, b = self.session(), self.session()
        a.declare("alive/1")
        self.settle(a, b)
        watch = b.watch("alive/*")
        assert self.collect(watch, 1) == [Sample("alive/1", b"1")]
        c = self.session()
        c.declare("alive/2")
        assert self.collect(watch, 1) == [Sample("alive/2", b"1")]
        a.close()
        assert self.collect(watch, 1) == [Sample("alive/1", b"")]

    def test_who_leaves_no_longer_answers(self) -> None:
        a, b = self.session(), self.session()
        a.serve("state/1/map", lambda _: b"map")
        self.settle(a, b)
        assert b.query("state/1/map")
        a.close()
        deadline = time.monotonic() + PATIENCE_S
        while b.query("state/1/map") and time.monotonic() < deadline:
            time.sleep(0.01)
        assert b.query("state/1/map") == []

    @pytest.mark.parametrize("key", ["", "/air", "air/", "a//b", "a#b", "a?b", "a*", "a$b", "$*"])
    def test_a_malformed_key_is_an_error(self, key: str) -> None:
        a = self.session()
        with pytest.raises(ValueError, match="key"):
            a.publish(key, b"")
        with pytest.raises(ValueError, match="key"):
            a.subscribe(key)
        with pytest.raises(ValueError, match="key"):
            a.serve(key, lambda _: b"")
        with pytest.raises(ValueError, match="key"):
            a.query(key)
        with pytest.raises(ValueError, match="key"):
            a.declare(key)

    def test_a_closed_session_says_so(self) -> None:
        a = self.session()
        a.publish("cmd/1", b"")
        a.close()
        a.close()
        for use in (
            lambda: a.publish("cmd/1", b""),
            lambda: a.publish("cmd/2", b""),
            lambda: a.subscribe("cmd/1"),
            lambda: a.watch("alive/*"),
            lambda: a.serve("state/1/map", lambda _: b""),
            lambda: a.query("state/1/map"),
            lambda: a.declare("alive/1"),
        ):
            with pytest.raises(BusError, match="closed"):
                use()


class TestLocalBus(Contract, LocalSessions):
    pass


class TestZenohBus(Contract, ZenohSessions):
    pass
