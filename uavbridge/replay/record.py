"""Joins a mission that flies and writes down what its bus carries."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from uavbridge.agent.phases import ENDED
from uavbridge.agent.report import decode as decode_report
from uavbridge.bus import keys
from uavbridge.bus.api import Bus, Sample
from uavbridge.bus.messages import decode_truth
from uavbridge.bus.wire import decode as decode_frame
from uavbridge.clock import pause, wall_s
from uavbridge.errors import BusError
from uavbridge.recording.recorder import Recorder

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

    @property
    def ended(self) -> bool:
        """Every agent that was heard of has landed or failed."""
        return bool(self.phases) and all(phase in ENDED_PHASES for phase in self.phases.values())

    def take(self, sample: Sample) -> None:
        """One sample; what is not recorded, or does not read, is left out."""
        space, _, rest = sample.key.partition("/")
        agent = keys.agent_of(sample.key)
        if space == "air" and (frame := decode_frame(sample.data)) is not None:
            self._write(f"air/{frame.sender}", frame.t_us, sample.data)
        elif sample.key == keys.TRUTH and (truth := decode_truth(sample.data)) is not None:
            self._write("truth", truth.t_us, sample.data)
        elif space == "state" and agent is not None and rest == str(agent):
            self._report(agent, sample.data)
        elif space == "state" and rest.endswith("/event"):
            self._write("event", self._t_us, sample.data)

    def _report(self, agent: int, data: bytes) -> None:
        try:
            report = decode_report(data)
        except msgspec.DecodeError:
            return
        self.phases[agent] = report.phase
        self._write(f"state/{agent}", report.t_us, data)

    def _write(self, topic: str, t_us: int, data: bytes) -> None:
        # Recordings are in order of time; what comes late is given the newest.
        self._t_us = max(self._t_us, t_us)
        self._recorder.write(topic, self._t_us, data)
        self.written += 1


def record(
    bus: Bus,
    recorder: Recorder,
    *,
    stop: Callable[[], bool] = lambda: False,
    progress: Callable[[int], None] = lambda _written: None,
) -> int:
    """Record a mission until it ends, or ``stop``; the number of messages written.

    Raises:
        BusError: nobody told what mission it is.
    """
    mailbox = bus.subscribe("**")
    until_s = wall_s() + FIRST_WORD_S
    while not (told := bus.query(keys.MISSION)):
        if wall_s() > until_s or stop():
            raise BusError("nobody on the bus tells what mission flies")
        pause(POLL_S)
    recorder.write("mission", 0, told[0].data)
    listener = Listener(recorder)
    while not stop():
        for sample in mailbox.drain():
            listener.take(sample)
        progress(listener.written)
        if listener.ended:
            break
        pause(POLL_S)
    mailbox.close()
    return listener.written + 1
