"""The face an autopilot shows: which numbers stand for its modes, how parameters travel."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Final, NamedTuple, Protocol

from sim_vehicles.codec import mav
from sim_vehicles.modes import MODES, Mode
from sim_vehicles.params import Type
from sim_vehicles.sensor_streams import SENSOR_FILLS
from sim_vehicles.streams import DEFAULT_INTERVALS_US, FILLS, Fill

COMMON_CAPABILITIES: Final[int] = (
    mav.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
    | mav.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | mav.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mav.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | mav.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
    | mav.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mav.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mav.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
)


class Answers(NamedTuple):
    """Results (MAV_RESULT) of what is not done."""

    refused: int = int(mav.MAV_RESULT_TEMPORARILY_REJECTED)  # a request, for now
    no_mode: int = int(mav.MAV_RESULT_DENIED)
    no_message: int = int(mav.MAV_RESULT_DENIED)  # to be sent once
    no_arming: int = int(mav.MAV_RESULT_DENIED)  # neither armed nor disarmed is asked for
    long_frame: int = int(mav.MAV_FRAME_GLOBAL)  # of the place in a COMMAND_LONG
    asks_for: str = "MISSION_REQUEST_INT"  # item by item, of an upload
    whole_vectors: bool = False  # of setpoints: a part to be ignored takes the rest along
    local_setpoints: bool = True  # SET_POSITION_TARGET_LOCAL_NED is heeded
    zero_is_here: bool = False  # latitude and longitude 0 in a command
    tells_modes: bool = True  # AVAILABLE_MODES, CURRENT_MODE
    strict_types: bool = True  # PARAM_SET must name the type of the parameter


class States(NamedTuple):
    """MAV_STATE by what the vehicle does."""

    unready: int = int(mav.MAV_STATE_UNINIT)
    ready: int = int(mav.MAV_STATE_STANDBY)
    grounded: int = int(mav.MAV_STATE_ACTIVE)  # armed, on the ground


class Flavour(Protocol):
    """How one make of autopilot says things; what it does is in the autopilot."""

    @property
    def autopilot(self) -> int:
        """MAV_AUTOPILOT in the heartbeat."""
        ...

    @property
    def capabilities(self) -> int:
        """MAV_PROTOCOL_CAPABILITY bits."""
        ...

    @property
    def version(self) -> int:
        """``flight_sw_version`` of AUTOPILOT_VERSION."""
        ...

    @property
    def greeting(self) -> tuple[str, ...]:
        """Texts that come with the list of parameters."""
        ...

    @property
    def answers(self) -> Answers:
        """How it refuses."""
        ...

    @property
    def states(self) -> States:
        """MAV_STATE of its heartbeats."""
        ...

    @property
    def home_first(self) -> bool:
        """Whether the first item of a mission is home, and not flown to."""
        ...

    @property
    def fills(self) -> Mapping[str, Fill]:
        """The messages that can be streamed."""
        ...

    @property
    def intervals_us(self) -> Mapping[str, int]:
        """Those sent unasked, microseconds between two."""
        ...

    @property
    def data_streams(self) -> Mapping[int, tuple[str, tuple[str, ...]]]:
        """By MAV_DATA_STREAM: the parameter of its rate, and its messages; empty: not heeded."""
        ...

    @property
    def id_parameter(self) -> str:
        """Name of the parameter that holds the system id."""
        ...

    def custom_mode(self, mode: Mode) -> int:
        """``custom_mode`` of the heartbeat."""
        ...

    def base_mode(self, mode: Mode, armed: bool) -> int:
        """``base_mode`` of the heartbeat."""
        ...

    def mode_of(self, custom_mode: int) -> Mode | None:
        """The mode that SET_MODE asks for; None: there is none."""
        ...

    def mode_of_command(self, main: int, sub: int) -> Mode | None:
        """The mode that params 2 and 3 of DO_SET_MODE ask for."""
        ...

    def encoded(self, kind: Type, value: float) -> float:
        """The float of PARAM_VALUE that carries a value."""
        ...

    def decoded(self, kind: Type, wire: float) -> float:
        """The value that a float of PARAM_SET carries."""
        ...


_AUTO: Final = 4
_MAIN: Final[Mapping[Mode, tuple[int, int]]] = {
    Mode.MANUAL: (1, 0),
    Mode.ALTITUDE: (2, 0),
    Mode.POSITION: (3, 0),
    Mode.TAKEOFF: (_AUTO, 2),
    Mode.HOLD: (_AUTO, 3),
    Mode.MISSION: (_AUTO, 4),
    Mode.RETURN: (_AUTO, 5),
    Mode.LAND: (_AUTO, 6),
    Mode.OFFBOARD: (6, 0),
}
_BY_MAIN: Final = {numbers: mode for mode, numbers in _MAIN.items()}
_SAME: Final = {(_AUTO, 0): Mode.MISSION}  # AUTO without more


class Px4:
    """PX4: main and sub mode in the upper bytes, whole parameters as raw bits."""

    autopilot: Final[int] = mav.MAV_AUTOPILOT_PX4
    capabilities: Final[int] = COMMON_CAPABILITIES | 16  # parameters as bits
    version: Final = 0x01_11_00_FF  # 1.17.0, a release
    greeting: Final[tuple[str, ...]] = ()
    answers: Final = Answers()
    states: Final = States()
    home_first: Final = False
    fills: Final[Mapping[str, Fill]] = {**FILLS, **SENSOR_FILLS}
    intervals_us: Final = DEFAULT_INTERVALS_US
    data_streams: Final[Mapping[int, tuple[str, tuple[str, ...]]]] = {}
    id_parameter: Final = "MAV_SYS_ID"

    def custom_mode(self, mode: Mode) -> int:
        main, sub = _MAIN[mode]
        return main << 16 | sub << 24

    def base_mode(self, mode: Mode, armed: bool) -> int:
        flags = int(mav.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED) | int(
            mav.MAV_MODE_FLAG_STABILIZE_ENABLED
        )
        spec = MODES[mode]
        if spec.auto:
            flags |= mav.MAV_MODE_FLAG_AUTO_ENABLED | mav.MAV_MODE_FLAG_GUIDED_ENABLED
        if spec.needs_sticks:
            flags |= mav.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
        return flags | (mav.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0)

    def mode_of(self, custom_mode: int) -> Mode | None:
        return self.mode_of_command(custom_mode >> 16 & 255, custom_mode >> 24 & 255)

    def mode_of_command(self, main: int, sub: int) -> Mode | None:
        numbers = (main, sub if main == _AUTO else 0)
        return _BY_MAIN.get(numbers, _SAME.get(numbers))

    def encoded(self, kind: Type, value: float) -> float:
        if kind is Type.REAL32:
            return value
        bits: float = struct.unpack("<f", struct.pack("<i", int(value)))[0]
        return bits

    def decoded(self, kind: Type, wire: float) -> float:
        if kind is Type.REAL32:
            return wire
        return float(struct.unpack("<i", struct.pack("<f", wire))[0])


PX4: Final = Px4()
