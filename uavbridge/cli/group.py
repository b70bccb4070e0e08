"""What all commands share: errors in one line, log on standard error, JSON on standard output."""

from __future__ import annotations

import errno
import logging
import sys
from contextlib import suppress
from typing import Any

import click
import msgspec

from uavbridge.errors import UavbridgeError


class Group(click.Group):
    """A group whose commands end with one line of error, never with a traceback of ours."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except UavbridgeError as error:
            click.echo(f"error: {' '.join(str(error).split())}", err=True)
            ctx.exit(error.exit_status)
        except OSError as error:
            if error.errno == errno.EPIPE:
                raise  # nobody reads on; click ends quietly
            click.echo(f"error: {error}", err=True)
            ctx.exit(1)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)  # in the order of use, not of the alphabet


class _OnStandardError(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        # Whatever standard error is now: a live view puts lines above itself, but only those
        # that come this way; click would write past it.
        if sys.stderr is None:
            return
        with suppress(OSError):  # nobody there to be told: no reason to stop
            sys.stderr.write(f"{record.levelname.lower()}: {record.getMessage()}\n")


def set_up_logging(verbosity: int) -> None:
    """Show log records of our packages: warnings, with 1 also what happens, with 2 everything."""
    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbosity, 2)]
    for name in ("planners", "sim_vehicles", "uavbridge"):
        logger = logging.getLogger(name)
        logger.setLevel(level)
        logger.handlers = [_OnStandardError()]


def echo_json(document: object) -> None:
    """One JSON document on standard output; what is not finite is null."""
    click.echo(msgspec.json.format(msgspec.json.encode(document), indent=2).decode())
