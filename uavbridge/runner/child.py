"""Processes that a launcher starts and ends."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import IO, Any

PATIENCE_S = 5.0  # for a child that was told to end


def spawn(
    arguments: Sequence[str], *, errors: IO[Any] | int | None = None
) -> subprocess.Popen[bytes]:
    """Start ``python -m`` with arguments; we speak to it by its standard input and output.

    Args:
        arguments: module and its arguments.
        errors: where its standard error goes; None: to ours.
    """
    return subprocess.Popen(
        [sys.executable, "-m", *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        start_new_session=True,  # Ctrl-C is for the parent to act on
        env={**os.environ, "PYTHONPATH": _module_path(), "PYTHONSAFEPATH": "1"},
    )


def end(process: subprocess.Popen[bytes], last_word: bytes = b"") -> None:
    """Close a child's standard input and wait for it; kill one that does not end by itself."""
    assert process.stdin is not None
    assert process.stdout is not None
    with suppress(BrokenPipeError, BlockingIOError):  # it died, or stands still
        if last_word:
            process.stdin.write(last_word)
        process.stdin.close()
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    process.stdout.close()


def _module_path() -> str:
    """Where this process finds its modules: the child finds the same ones, wherever it starts."""
    return os.pathsep.join(path or os.getcwd() for path in sys.path)
