"""How ArduPilot says things."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from sim_vehicles.ardupilot.streams import DATA_STREAMS, FILLS, INTERVALS_US
from sim_vehicles.codec import mav
from sim_vehicles.flavour import Answers, States
from sim_vehicles.modes import Mode
from sim_vehicles.params import Type
from sim_vehicles.streams import Fill

_FAILED: Final[int] = mav.MAV_RESULT_FAILED

_ANSWERS: Final = Answers(
    refused=_FAILED,
    no_mode=_FAILED,
    no_message=_FAILED,
    no_arming=int(mav.MAV_RESULT_UNSUPPORTED),
    long_frame=int(mav.MAV_FRAME_GLOBAL_RELATIVE_ALT),
    asks_for="MISSION_REQUEST",
    whole_vectors=True,
    zero_is_here=True,
    tells_modes=False,
    strict_types=False,
)


class ArduPilot:
    """One of ArduPilot's vehicles.

    Args:
        name: of the firmware: "ArduCopter".
        modes: ``custom_mode`` and, besides CUSTOM_MODE_ENABLED, ``base_mode`` of each mode.
        capabilities: MAV_PROTOCOL_CAPABILITY bits, without the file transfer that is not here.
        states: MAV_STATE by what it does.
        frame: a text about the frame.
        local_setpoints: it heeds SET_POSITION_TARGET_LOCAL_NED.
    """

    autopilot: Final[int] = mav.MAV_AUTOPILOT_ARDUPILOTMEGA
    version: Final = 67503103  # 4.6.3, a release
    home_first: Final = True
    fills: Final[Mapping[str, Fill]] = FILLS
    intervals_us: Final[Mapping[str, int]] = INTERVALS_US
    data_streams: Final = DATA_STREAMS
    id_parameter: Final = "SYSID_THISMAV"

    def __init__(
        self,
        name: str,
        modes: Mapping[Mode, tuple[int, int]],
        capabilities: int,
        states: States,
        frame: str = "",
        *,
        local_setpoints: bool = True,
    ) -> None:
        self._modes = modes
        self._by_number = {number: mode for mode, (number, _) in modes.items()}
        self.answers = _ANSWERS._replace(local_setpoints=local_setpoints)
        self.capabilities = capabilities
        self.states = states
        self.greeting = (f"{name} V4.6.3 (simulated)", *((frame,) if frame else ()))

    def custom_mode(self, mode: Mode) -> int:
        return self._modes[mode][0]

    def base_mode(self, mode: Mode, armed: bool) -> int:
        flags = self._modes[mode][1] | int(mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
        return flags | (int(mav.MAV_MODE_FLAG_SAFETY_ARMED) if armed else 0)

    def mode_of(self, custom_mode: int) -> Mode | None:
        return self._by_number.get(custom_mode)

    def mode_of_command(self, main: int, sub: int) -> Mode | None:
        return self._by_number.get(main)

    def encoded(self, kind: Type, value: float) -> float:
        return value

    def decoded(self, kind: Type, wire: float) -> float:
        return wire if kind is Type.REAL32 else float(round(wire)) if abs(wire) < 2**31 else wire
