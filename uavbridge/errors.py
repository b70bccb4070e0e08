"""What can go wrong, by whose fault, and the exit status it leads to."""

from __future__ import annotations


class UavbridgeError(Exception):
    """Root of all errors that a user is told of in one line."""

    exit_status = 1


class ConfigError(UavbridgeError):
    """The mission file, an option or an argument is wrong. The message names file and key."""

    exit_status = 2


class BusError(UavbridgeError):
    """The router is not there, or refused the session."""


class LinkError(UavbridgeError):
    """A port is taken, or an endpoint cannot be opened."""


class VehicleError(UavbridgeError):
    """A vehicle never answered, or refused what it must do. The message names id and reason."""
