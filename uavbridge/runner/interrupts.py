"""Ctrl-C and its like: once for an orderly end, twice to stop at once."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_log = logging.getLogger(__name__)


class Interrupted(KeyboardInterrupt):
    """Ctrl-C for the second time: stop at once."""


@contextmanager
def interrupts(notice: str = "") -> Iterator[Callable[[], bool]]:
    """Ctrl-C, SIGTERM and SIGHUP ask for an orderly end; a second one raises ``Interrupted``.

    Args:
        notice: logged at the first, unless it is empty.

    A hang-up that is ignored already, as under nohup, stays so. Off the main thread, where
    Python takes no signals, nothing asks.
    """
    asked = 0
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return

    def on_signal(number: int, _frame: FrameType | None) -> None:
        nonlocal asked
        asked += 1
        if asked > 1:
            raise Interrupted
        if notice:
            _log.warning("%s", notice)

    taken = [signal.SIGINT, signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        taken.append(signal.SIGHUP)
    before = {number: signal.signal(number, on_signal) for number in taken}
    try:
        yield lambda: asked > 0
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
