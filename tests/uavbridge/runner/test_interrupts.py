"""Ctrl-C and its like."""

import os
import signal

import pytest

from uavbridge.runner.interrupts import Interrupted, interrupts


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_first_asks_and_the_second_stops(number, caplog):
    before = signal.getsignal(number)
    with interrupts("orderly") as stop:
        assert not stop()
        os.kill(os.getpid(), number)
        assert stop()
        assert caplog.messages == ["orderly"]
        with pytest.raises(Interrupted):
            os.kill(os.getpid(), number)
    assert signal.getsignal(number) is before


def test_under_nohup_a_hang_up_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interrupts("orderly") as stop:
            os.kill(os.getpid(), signal.SIGHUP)
            assert not stop()
    finally:
        signal.signal(signal.SIGHUP, before)
