"""Why a vehicle can not arm yet, in words for people."""

from __future__ import annotations

from uavbridge.clock import to_s, to_us
from uavbridge.mavlink.telemetry import Telemetry

_COMPLAINT_US = to_us(30.0)  # ArduPilot repeats what is wrong every 30 s
_TWINS_US = to_us(10.0)
_TWIN_RESTARTS = 3
_WARNING = 4
_FARTHEST_M = 15.0  # two readings of one place


class Readiness:
    """What one vehicle waits for, from its telemetry and its own texts."""

    def __init__(self, system: int, telemetry: Telemetry) -> None:
        self._system = system
        self._telemetry = telemetry
        self._complaints: dict[str, int] = {}  # text -> when

    def said(self, severity: int, text: str, t_us: int) -> None:
        """Remember a text of the autopilot if it may say what is wrong."""
        if severity <= _WARNING and not self._telemetry.armed:
            self._complaints[text] = t_us

    def forget(self) -> None:
        """It has restarted: what it said is no longer true."""
        self._complaints.clear()

    def waiting_for(self, now_us: int, silent_us: float | None) -> tuple[str, ...]:
        """Reasons; empty when it can arm, or has.

        Args:
            now_us: mission time.
            silent_us: how long nothing was heard, if too long; else None.
        """
        telemetry = self._telemetry
        if isinstance(telemetry.flavour, str):
            return (telemetry.flavour,)
        if silent_us is not None:
            return (f"silent for {silent_us / 1e6:.1f} s",)
        recent = telemetry.restarts_us[-_TWIN_RESTARTS:]
        if len(recent) == _TWIN_RESTARTS and now_us - recent[0] < _TWINS_US:
            return (f"two vehicles seem to use system id {self._system}",)
        if telemetry.armed:
            return ()
        reasons = []
        if telemetry.estimate_ok is False:
            reasons.append("its estimator (EKF) has no position yet" + self._restarted())
        elif not telemetry.has_position:
            reasons.append("no position yet" + self._restarted())
        elif telemetry.disagreement_m > _FARTHEST_M:
            apart = f"{telemetry.disagreement_m:.0f} m"
            reasons.append(f"its local and its global position are {apart} apart")
        if telemetry.frame is None:
            reasons.append("origin of its local frame not known yet" + self._restarted())
        if telemetry.checks_failed:
            said = [t for t, t_us in self._complaints.items() if now_us - t_us <= _COMPLAINT_US]
            reasons.append("pre-arm checks fail" + (": " + "; ".join(said) if said else ""))
        return tuple(reasons)

    def _restarted(self) -> str:
        times = self._telemetry.restarts_us
        return f" (it restarted at {to_s(times[-1]):.1f} s)" if times else ""
