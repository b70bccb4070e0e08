"""What can go wrong, by whose fault, and the exit status it leads to."""

from __future__ import annotations

from typing import Self


class UavbridgeError(Exception):
    """Root of all errors that a user is told of in one line."""

    exit_status = 1

    def at(self, place: str) -> Self:
        """The same, with the file or the key that it is about before it."""
        return type(self)(f"{place}: {self}")


class ConfigError(UavbridgeError):
    """The mission file, an option or an argument is wrong. The message names file and key."""

    exit_status = 2


class BusError(UavbridgeError):
    """The router is not there, or refused the session."""


class LinkError(UavbridgeError):
    """A port is taken, or an endpoint cannot be opened."""


class VehicleError(UavbridgeError):
    """A vehicle never answered, or refused what it must do. The message names id and reason."""
