"""The autopilot's own safety net, set and put back by MAVSDK's parameter plugin."""

from __future__ import annotations

from typing import Any

from uavbridge.errors import VehicleError
from uavbridge.mavlink.ardupilot import ARDUCOPTER
from uavbridge.mavlink.parameters import Kind, same
from uavbridge.mavlink.px4 import Px4
from uavbridge.vehicle.api import Net


class Nets:
    """Parameters of one vehicle.

    Args:
        param: MAVSDK's plugin.
        autopilot: name of its make in MAVSDK.
    """

    def __init__(self, param: Any, autopilot: str) -> None:
        self._param = param
        self._flavour = ARDUCOPTER if autopilot == "ARDUPILOT" else Px4()
        self._whole = autopilot != "ARDUPILOT"
        self.before: dict[str, tuple[float, Kind]] = {}

    def cast(self, net: Net) -> None:
        """Set it and read it back.

        Raises:
            VehicleError: a parameter does not keep what it is set to.
        """
        for setting in self._flavour.net(net):
            for name, value in setting.names:
                found = self._get(name, setting.kind)
                if found is None:
                    continue
                if not same(found, value):
                    self.before.setdefault(name, (found, setting.kind))
                    self._set(name, value, setting.kind)
                break

    def restore(self) -> None:
        """Put it back. Raises VehicleError as ``cast``."""
        for name, (value, kind) in reversed(self.before.items()):
            self._set(name, value, kind)
        self.before = {}

    def _get(self, name: str, kind: Kind) -> float | None:
        try:
            if self._whole and kind is not Kind.REAL32:
                return float(self._param.get_param_int(name))
            return float(self._param.get_param_float(name))
        except self._errors():
            return None

    def _set(self, name: str, value: float, kind: Kind) -> None:
        if self._whole and kind is not Kind.REAL32:
            self._param.set_param_int(name, int(value))
        else:
            self._param.set_param_float(name, float(value))
        found = self._get(name, kind)
        if found is None or not same(found, value):
            raise VehicleError(f"safety net: {name} was set to {value:g} but reads {found}")

    @staticmethod
    def _errors() -> type[Exception]:
        from mavsdk.exceptions import MavsdkError

        error: type[Exception] = MavsdkError
        return error
