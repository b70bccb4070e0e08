"""Programs from start to end: Ctrl-C while one is loaded, or ends, leaves no traceback."""

from __future__ import annotations

import signal

TYPE_CHECKING = False  # as in ``typing``: nothing is loaded here that need not be
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, TypeAlias

    Program: TypeAlias = Callable[..., Any]


def load_and_run(load: Callable[[], Program], name: str) -> None:
    """Run a command line; Ctrl-C before and after it just ends the process.

    Args:
        load: imports it.
        name: what it is called in its help.
    """
    mine = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else somebody's
    if mine:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    program = load()
    if mine:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        program(prog_name=name)
    finally:
        if mine:
            signal.signal(signal.SIGINT, signal.SIG_DFL)
