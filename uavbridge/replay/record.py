"""Joins a mission that flies and writes down what its bus carries."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress

import msgspec

from uavbridge.agent.phases import ENDED
from uavbridge.agent.report import decode as decode_report
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Sample
from uavbridge.bus.messages import decode_readings, decode_truth
from uavbridge.bus.wire import decode as decode_frame
from uavbridge.clock import pause, to_s, wall_s
from uavbridge.errors import BusError
from uavbridge.monitor.watch import MissionWatch
from uavbridge.monitor.watched import Point
from uavbridge.recording.display import Display
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import (
    EventRecord,
    ReadingRecord,
    ScoreRecord,
    decode,
    encode,
    known,
)
from uavbridge.report.result import Event

POLL_S = 0.05
FIRST_WORD_S = 3.0
ENDED_PHASES = frozenset(phase.value for phase in ENDED)


class Listener:
    """Turns what the bus carries into recorded messages.

    Args:
        recorder: gets them.

    Attributes:
        written: messages so far.
        phases: of each agent, by its newest report.
    """

    def __init__(self, recorder: Recorder) -> None:
        self.written = 0
        self.phases: dict[int, str] = {}
        self._recorder = recorder
        self._t_us = 0

    def take(self, sample: Sample) -> None:
        """One sample; what is not recorded, or does not read, is left out."""
        space, _, rest = sample.key.partition("/")
        agent = keys.agent_of(sample.key)
        if space == "air" and (frame := decode_frame(sample.data)) is not None:
            self.write(f"air/{frame.sender}", frame.t_us, sample.data)
        elif sample.key == keys.TRUTH and (truth := decode_truth(sample.data)) is not None:
            self.write("truth", truth.t_us, sample.data)
        elif space == "state" and agent is not None and rest == str(agent):
            self._report(agent, sample.data)
        elif space == "state" and rest.endswith("/event"):
            self.event(sample.data)

    def event(self, data: bytes) -> None:
        """An event, whoever tells of it."""
        with suppress(msgspec.DecodeError):
            decode(EventRecord, data)
            self.write("event", self._t_us, data)

    def _report(self, agent: int, data: bytes) -> None:
        try:
            report = decode_report(data)
        except msgspec.DecodeError:
            return
        self.phases[agent] = report.phase
        self.write(f"state/{agent}", report.t_us, data)

    def write(self, topic: str, t_us: int, data: bytes) -> None:
        """One message, not before the one before: what comes late is given its time."""
        self._t_us = max(self._t_us, t_us)
        self._recorder.write(topic, self._t_us, data)
        self.written += 1


class Onlooker:
    """Writes down a whole mission from its bus, with the scores that it works out itself.

    Args:
        recorder: gets the messages.

    Attributes:
        watch: the mission, as far as it was heard.
    """

    def __init__(self, recorder: Recorder) -> None:
        self.watch = MissionWatch()
        self._recorder = recorder
        self._listener = Listener(recorder)
        self._display: Display | None = None
        self._scored = 0

    @property
    def written(self) -> int:
        """Messages so far, but for what Foxglove shows."""
        return self._listener.written

    def take(self, sample: Sample) -> None:
        """One sample; what does not read is left out."""
        rejected, was_told = self.watch.rejects.total(), self.watch.record
        self.watch.apply(sample)
        t_us = max(self.watch.t_us, 0)
        self._listener.take(sample)
        if self.watch.rejects.total() == rejected:
            for topic, data in _more(sample):
                self._listener.write(topic, t_us, data)
        if self.watch.record is not was_told:
            self._listener.write("mission", t_us, sample.data)
            if self.watch.facts is not None:
                self._display = Display(self._recorder, self.watch.facts)
        if len(self.watch.series) > self._scored:
            self._second()

    def _second(self) -> None:
        """What the mission's judge would record of the last second, and what people see."""
        watch, recalled = self.watch, self._scored == 0 and len(self.watch.series) > 1
        point = watch.series[-1]
        self._scored = len(watch.series)
        if not recalled:
            self._listener.write("score", point.t_us, encode(score_of(point)))
        if self._display is None:
            return
        reports = [agent.report for agent in watch.agents.values() if agent.report]
        self._display.second(watch.t_us, reports, watch.merged(), watch.declared)
        if new := watch.event_count - self._display.logged:
            told = [Event(to_s(e.t_us), e.text, e.agent, e.kind) for e in watch.events]
            self._display.log(told[-new:])


def score_of(point: Point) -> ScoreRecord:
    """A second of a watch as the judge would record it."""
    return ScoreRecord(
        point.coverage, point.entropy, point.uncertainty, point.found, known(point.separation_m)
    )


def _more(sample: Sample) -> Iterator[tuple[str, bytes]]:
    """Topic and data of what a ``Listener`` leaves out."""
    space, _, rest = sample.key.partition("/")
    if space == "state" and rest.endswith("/map"):
        yield f"fullmap/{keys.agent_of(sample.key)}", sample.data
    elif space == "cmd":
        yield f"cmd/{rest}", sample.data
    elif space == "layer":
        yield sample.key, sample.data
    elif sample.key == keys.PAST:
        yield "past", sample.data
    elif space == "obs" and (readings := decode_readings(sample.data)) is not None:
        for column, row, detected in readings.looks:
            record = ReadingRecord(column, row, detected, readings.t_us)
            yield f"obs/{rest}", encode(record)


class Joined:
    """A mission's bus, from the middle on.

    Args:
        bus: its session.
        stop: asked while nobody tells what mission it is.

    Attributes:
        before: what was: the mission, its past, whole maps.

    Raises:
        BusError: nobody told what mission it is.
    """

    def __init__(self, bus: Bus, stop: Callable[[], bool] = lambda: False) -> None:
        self._mailboxes = (bus.subscribe("**"), bus.watch(keys.alive("*")))
        until_s = wall_s() + FIRST_WORD_S
        while not (told := bus.query(keys.MISSION)):
            if wall_s() > until_s or stop():
                raise BusError("nobody on the bus tells what mission flies")
            pause(POLL_S)
        self.before = [told[0], *bus.query(keys.PAST), *bus.query(keys.state_map("*"))]

    def drain(self) -> list[Sample]:
        """All since the last call."""
        return [sample for mailbox in self._mailboxes for sample in mailbox.drain()]

    def close(self) -> None:
        """Listen no more."""
        for mailbox in self._mailboxes:
            mailbox.close()


def record(
    joined: Joined,
    onlooker: Onlooker,
    *,
    stop: Callable[[], bool] = lambda: False,
    progress: Callable[[int], None] = lambda _t_us: None,
) -> int:
    """Record a mission until it ends, or ``stop``; the number of messages written.

    Args:
        joined: its bus.
        onlooker: writes.
        stop: asked twenty times a second.
        progress: told the mission time as often.
    """
    for sample in joined.before:
        onlooker.take(sample)
    while not stop():
        for sample in joined.drain():
            onlooker.take(sample)
        progress(onlooker.watch.t_us)
        if onlooker.watch.ended:
            break
        pause(POLL_S)
    joined.close()
    return onlooker.written
