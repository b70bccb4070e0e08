"""Buses for tests, local and live, behind one face."""

import time
from collections.abc import Callable, Iterator
from itertools import count

import pytest

from uavbridge.bus.api import Bus, Mailbox, Sample
from uavbridge.bus.local import LocalHub
from uavbridge.bus.zenoh_bus import Router, ZenohBus

PATIENCE_S = 5.0
missions = count()


class Sessions:
    """``session()`` opens a new session of the same mission at every call."""

    session: Callable[[], Bus]

    def collect(self, mailbox: Mailbox, count: int) -> list[Sample]:
        """The next samples; on a live bus they take a moment."""
        samples = mailbox.drain()
        deadline = time.monotonic() + PATIENCE_S
        while len(samples) < count and time.monotonic() < deadline:
            time.sleep(0.002)
            samples += mailbox.drain()
        return samples

    def settle(self, sender: Bus, *receivers: Bus) -> None:
        """Return when what ``sender`` published so far has arrived, and who subscribed is known."""
        mark = f"obs/settle{time.monotonic_ns()}"
        boxes = [receiver.subscribe(mark) for receiver in receivers]
        waiting = list(boxes)
        deadline = time.monotonic() + PATIENCE_S
        while waiting and time.monotonic() < deadline:
            sender.publish(mark, b"")
            waiting = [box for box in waiting if not box.drain()]
            if waiting:
                time.sleep(0.002)
        assert not waiting
        for box in boxes:
            box.close()


class LocalSessions(Sessions):
    @pytest.fixture(autouse=True)
    def _sessions(self) -> None:
        self.session = LocalHub().bus


@pytest.mark.integration
class ZenohSessions(Sessions):
    @pytest.fixture(autouse=True)
    def _sessions(self, router: Router) -> Iterator[None]:
        opened: list[ZenohBus] = []
        mission = f"test {next(missions)}"

        def session() -> ZenohBus:
            opened.append(ZenohBus(router.endpoint, mission))
            return opened[-1]

        self.session = session
        yield
        for bus in opened:
            bus.close()
