"""The autopilot's own safety net: set, read back, put back."""

from __future__ import annotations

import pytest

from sim_vehicles.codec import Counts, Encoder, decode
from uavbridge.mavlink.ardupilot import ARDUCOPTER, ARDUPLANE, ARDUROVER
from uavbridge.mavlink.flavour import PX4, Flavour
from uavbridge.mavlink.parameters import Kind, Parameters, from_wire, to_wire
from uavbridge.vehicle.api import Done, Net, Refused, RestoreNet, Said, SetNet, VehicleEvent
from uavbridge.vehicle.safety_net import SafetyNet

NET = Net(fence_radius_m=300.0, fence_height_m=80.0, return_height_m=30.0)
PX4_VALUES = {
    "GF_MAX_HOR_DIST": 0.0,
    "GF_MAX_VER_DIST": 0.0,
    "GF_ACTION": 2.0,
    "RTL_RETURN_ALT": 30.0,
    "MIS_TAKEOFF_ALT": 2.5,
    "COM_OF_LOSS_T": 1.0,
    "COM_OBL_RC_ACT": 0.0,
    "COM_DL_LOSS_T": 10.0,
    "NAV_DLL_ACT": 0.0,
}
COPTER_VALUES = {
    "SYSID_MYGCS": 255.0,
    "FENCE_RADIUS": 150.0,
    "FENCE_ACTION": 1.0,
    "FENCE_TYPE": 7.0,
    "FENCE_ALT_MAX": 100.0,
    "RTL_ALT": 1500.0,
    "GUID_TIMEOUT": 3.0,
    "FS_GCS_TIMEOUT": 5.0,
    "FS_GCS_ENABLE": 0.0,
    "FENCE_ENABLE": 0.0,
}


class Autopilot:
    """Answers for parameters; of some it says one thing and does another."""

    def __init__(self, values: dict[str, float], flavour: Flavour) -> None:
        self.values = dict(values)
        self.set: list[str] = []
        self.stubborn: set[str] = set()
        self.forgets: set[str] = set()
        self._encoder = Encoder(1)
        self._bytewise = flavour.bytewise_parameters
        parameters = Parameters(Encoder(245, 190), 1, bytewise=self._bytewise)
        self.net = SafetyNet(parameters)
        self._flavour = flavour
        self.t_us = 0

    def _kind(self, name: str) -> Kind:
        whole = ("GF_ACTION", "COM_OBL_RC_ACT", "COM_DL_LOSS_T", "NAV_DLL_ACT", "RTL_ALT")
        return Kind.INT32 if name in whole else Kind.REAL32

    def _answer(self, name: str) -> None:
        kind = self._kind(name)
        value = to_wire(self.values[name], kind, bytewise=self._bytewise)
        frame = self._encoder.pack(
            "PARAM_VALUE", param_id=name, param_value=value, param_type=int(kind)
        )
        (packet,) = decode(frame, Counts())
        self.net.hear(packet.message, self.t_us)

    def run(self, seconds: float = 20.0) -> list[VehicleEvent]:
        events: list[VehicleEvent] = []
        for _ in range(round(seconds * 10)):
            self.t_us += 100_000
            told, frames = self.net.advance(self.t_us)
            events += told
            for packet in decode(b"".join(frames), Counts()):
                message = packet.message
                name = message.param_id
                if name not in self.values:
                    continue
                if message.msgname == "PARAM_SET" and name not in self.stubborn:
                    value = from_wire(
                        message.param_value, message.param_type, bytewise=self._bytewise
                    )
                    self.set.append(name)
                    before, self.values[name] = self.values[name], value
                    self._answer(name)
                    if name in self.forgets:
                        self.values[name] = before
                else:
                    self._answer(name)
        return events

    def cast(self) -> list[VehicleEvent]:
        self.net.start(SetNet(NET), self._flavour.net(NET), self.t_us)
        return self.run()


def test_px4_gets_a_fence_and_what_to_do_when_we_are_gone() -> None:
    autopilot = Autopilot(PX4_VALUES, PX4)
    assert autopilot.cast() == [Done(SetNet(NET))]
    assert autopilot.values == {
        "GF_MAX_HOR_DIST": 300.0,
        "GF_MAX_VER_DIST": 80.0,
        "GF_ACTION": 3.0,
        "RTL_RETURN_ALT": 30.0,
        "MIS_TAKEOFF_ALT": 10.0,
        "COM_OF_LOSS_T": 2.0,
        "COM_OBL_RC_ACT": 5.0,
        "COM_DL_LOSS_T": 10.0,
        "NAV_DLL_ACT": 2.0,
    }
    assert "RTL_RETURN_ALT" not in autopilot.set  # it was so already
    autopilot.net.restore(autopilot.t_us)
    assert autopilot.run() == [Done(RestoreNet())]
    assert autopilot.values == PX4_VALUES
    assert not autopilot.net.cast


def test_copter_turns_the_fence_on_last_and_off_first() -> None:
    autopilot = Autopilot(COPTER_VALUES, ARDUCOPTER)
    assert autopilot.cast() == [Done(SetNet(NET))]
    assert autopilot.values["RTL_ALT"] == 3000.0  # cm
    assert autopilot.values["SYSID_MYGCS"] == 245.0
    assert autopilot.set[-1] == "FENCE_ENABLE"
    autopilot.set.clear()
    autopilot.net.restore(autopilot.t_us)
    assert autopilot.run() == [Done(RestoreNet())]
    assert autopilot.values == COPTER_VALUES
    assert autopilot.set[0] == "FENCE_ENABLE"


def test_newer_names_are_found_and_missing_ones_told() -> None:
    values = dict(COPTER_VALUES)
    values["MAV_GCS_SYSID"] = values.pop("SYSID_MYGCS")
    values["RTL_ALT_M"] = values.pop("RTL_ALT") / 100.0
    del values["GUID_TIMEOUT"]
    autopilot = Autopilot(values, ARDUCOPTER)
    said, done = autopilot.cast()
    assert said == Said(5, "safety net: it has no parameter GUID_TIMEOUT")
    assert done == Done(SetNet(NET))
    assert autopilot.values["RTL_ALT_M"] == 30.0
    assert autopilot.values["MAV_GCS_SYSID"] == 245.0


@pytest.mark.parametrize(
    ("how", "words"),
    [("stubborn", "GF_ACTION stays 2, not 3"), ("forgets", "set to 3 but reads 2")],
)
def test_what_does_not_hold_is_refused_by_name(how: str, words: str) -> None:
    autopilot = Autopilot(PX4_VALUES, PX4)
    getattr(autopilot, how).add("GF_ACTION")
    (event,) = autopilot.cast()
    assert isinstance(event, Refused)
    assert "GF_ACTION" in event.reason
    assert words in event.reason


@pytest.mark.parametrize("flavour", [PX4, ARDUCOPTER, ARDUROVER, ARDUPLANE])
def test_every_flavour_has_a_net_with_fence_and_link_loss(flavour: Flavour) -> None:
    names = {name for setting in flavour.net(NET) for name, _ in setting.names}
    assert names & {"GF_MAX_HOR_DIST", "FENCE_RADIUS"}
    assert names & {"NAV_DLL_ACT", "FS_GCS_ENABLE", "FS_GCS_ENABL"}
    assert all(len(name) <= 16 for name in names)
