"""One vehicle on the doctor's table: its parameters, its clock, what it waits for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sim_vehicles.codec import Encoder
from uavbridge.clock import SECOND_US, wall_date
from uavbridge.config import Mission
from uavbridge.doctor.bites import BITES
from uavbridge.doctor.finding import Finding, error, ok, warning
from uavbridge.mavlink.exchange import Patience
from uavbridge.mavlink.flavour import Flavour
from uavbridge.mavlink.hub import Hub
from uavbridge.mavlink.parameters import Parameters
from uavbridge.mavlink.scout import Scout

_PATIENCE = Patience(tries=6, retry_s=0.5)
_LOW_BATTERY = 0.3
_MOST_OFF_S = 5.0  # a vehicle's date may differ by
_SLOW_TRIP_S = 0.3
_OLDEST = {
    "PX4": (1, 14, 0),
    "ArduCopter": (4, 3, 0),
    "ArduRover": (4, 3, 0),
    "ArduPlane": (4, 3, 0),
}


class Checkup:
    """Asks one vehicle.

    Args:
        scout: hears it.
        hub: speaks to it.
        encoder: packs for this end.
    """

    def __init__(self, scout: Scout, hub: Hub, encoder: Encoder) -> None:
        self.scout, self._hub = scout, hub
        self._encoder = encoder
        self._parameters: Parameters | None = None
        self._asks: set[int] = set()
        self.trip_s: float | None = None
        """Shortest round trip of a TIMESYNC."""
        self.date_off_s: float | None = None
        """Its date less ours."""
        self._sync_us = 0
        scout.handlers["TIMESYNC"] = self._timesync
        scout.handlers["SYSTEM_TIME"] = self._system_time
        scout.handlers["PARAM_VALUE"] = self._parameter

    @property
    def values(self) -> dict[str, float]:
        """Its parameters, those that were asked for and answered."""
        return {} if self._parameters is None else self._parameters.values

    @property
    def done(self) -> bool:
        """Nothing more is to be asked."""
        return self._parameters is not None and not self._asks and self.trip_s is not None

    def step(self, t_us: int) -> None:
        """Ask what is due."""
        flavour = self.scout.telemetry.flavour
        if isinstance(flavour, str) or not self.scout.heard:
            return
        if self._parameters is None:
            self._parameters = self._begin(flavour, t_us)
        frames = self._parameters.due(t_us)
        for verdict in self._parameters.take():
            self._asks.discard(verdict.ticket)
        if t_us >= self._sync_us:
            self._sync_us = t_us + SECOND_US
            frames.append(self._encoder.pack("TIMESYNC", tc1=0, ts1=t_us * 1000))
        if frames:
            self._hub.send(self.scout.system, b"".join(frames))

    def _begin(self, flavour: Flavour, t_us: int) -> Parameters:
        parameters = Parameters(
            self._encoder,
            self.scout.system,
            self.scout.component,
            bytewise=flavour.bytewise_parameters,
            patience=_PATIENCE,
        )
        self._asks = {parameters.get(bite.name, t_us) for bite in BITES[flavour.name]}
        return parameters

    def _parameter(self, message: Any, t_us: int) -> None:
        if self._parameters is not None:
            self._parameters.hear(message, t_us)

    def _timesync(self, m: Any, t_us: int) -> None:
        if m.tc1:
            trip_s = (t_us - m.ts1 // 1000) * 1e-6
            if trip_s >= 0 and (self.trip_s is None or trip_s < self.trip_s):
                self.trip_s = trip_s

    def _system_time(self, m: Any, t_us: int) -> None:
        if m.time_unix_usec:
            self.date_off_s = m.time_unix_usec * 1e-6 - wall_date().timestamp()

    def findings(self, subject: str, mission: Mission, now_us: int) -> Iterator[Finding]:
        """What is to be said of it.

        Args:
            subject: what to call it.
            mission: that it is to fly.
            now_us: the time that ``step`` was given last.
        """
        yield from self._firmware(subject)
        yield from self._readiness(subject, now_us)
        yield from self._clock(subject)
        yield from self._bites(subject, mission)

    def _firmware(self, subject: str) -> Iterator[Finding]:
        firmware, name = self.scout.firmware, self.scout.name
        if firmware is None:
            yield warning(subject, f"{name}: does not tell its version")
            return
        oldest = _OLDEST.get(name, (0, 0, 0))
        if firmware.version < oldest:
            asked = ".".join(map(str, oldest))
            text = f"{name} {firmware}: older than any that this was flown with"
            yield warning(subject, text, f"update it to {asked} or later")
        else:
            yield ok(subject, f"{name} {firmware}")

    def _readiness(self, subject: str, now_us: int) -> Iterator[Finding]:
        telemetry = self.scout.telemetry
        reasons = self.scout.readiness.waiting_for(now_us, None)
        for reason in reasons:
            yield error(subject, f"waits for: {reason}", "mend that, or wait and look again")
        if telemetry.armed:
            yield error(subject, f"is armed, in {telemetry.mode_text}", "disarm it first")
        elif not reasons:
            yield ok(subject, f"ready to arm, in {telemetry.mode_text}")
        battery = telemetry.battery
        if battery < _LOW_BATTERY:
            yield error(subject, f"battery at {battery:.0%}", "charge or change it")

    def _clock(self, subject: str) -> Iterator[Finding]:
        rate = self.scout.rate
        if self.trip_s is None:
            yield warning(subject, "does not answer TIMESYNC")
        else:
            pace = "" if rate is None else f", its clock goes {rate:.2f} times ours"
            text = f"answers in {self.trip_s * 1e3:.1f} ms{pace}"
            slow = self.trip_s > _SLOW_TRIP_S
            remedy = "a faster link: setpoints come late"
            yield warning(subject, text, remedy) if slow else ok(subject, text)
        off_s = self.date_off_s
        if off_s is not None and abs(off_s) > _MOST_OFF_S and rate is not None and rate < 1.5:
            text = f"its date is {off_s:+.0f} s off this machine's"
            yield warning(subject, text, "set this machine's clock (NTP): logs will not match")

    def _bites(self, subject: str, mission: Mission) -> Iterator[Finding]:
        for bite in BITES.get(self.scout.name, ()):
            value = self.values.get(bite.name)
            if value is not None and bite.bites(value, mission):
                text = f"{bite.name} is {value:g}: {bite.text}"
                yield Finding(subject, bite.level, text, bite.remedy)
