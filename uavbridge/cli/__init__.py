"""The command line: ``uavbridge COMMAND``."""

from uavbridge.cli.commands import main

__all__ = ["main"]
