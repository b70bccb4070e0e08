"""What the doctor found, one thing at a time."""

from __future__ import annotations

from enum import Enum

from msgspec import Struct


class Level(Enum):
    """How bad it is."""

    OK = "ok"
    WARNING = "warning"  # it can be flown, but will not go as expected
    ERROR = "error"  # the mission can not be flown like this


class Finding(Struct, frozen=True, omit_defaults=True):
    """One fact about the machine, the mission or a vehicle."""

    subject: str  # "udp port 14540", "agent 3", "router", ...
    level: Level
    text: str
    remedy: str = ""  # what to do about it


class Diagnosis(Struct, frozen=True):
    """All of it."""

    mission: str
    ready: bool  # the mission could fly now
    findings: tuple[Finding, ...]

    def lines(self) -> list[str]:
        """For people: what is wrong with what to do below it, then the verdict."""
        marks = {Level.OK: "ok", Level.WARNING: "warn", Level.ERROR: "ERROR"}
        width = max((len(f.subject) for f in self.findings), default=0)
        lines = []
        for finding in self.findings:
            lines.append(f"{marks[finding.level]:5}  {finding.subject:{width}}  {finding.text}")
            if finding.remedy:
                lines.append(f"{'':5}  {'':{width}}  -> {finding.remedy}")
        errors = sum(finding.level is Level.ERROR for finding in self.findings)
        verdict = "could fly now" if self.ready else f"can not fly: {errors} thing(s) to mend"
        return [*lines, f"mission {self.mission} {verdict}"]


def ok(subject: str, text: str) -> Finding:
    """As it should be."""
    return Finding(subject, Level.OK, text)


def warning(subject: str, text: str, remedy: str = "") -> Finding:
    """Worth knowing."""
    return Finding(subject, Level.WARNING, text, remedy)


def error(subject: str, text: str, remedy: str = "") -> Finding:
    """To be mended first."""
    return Finding(subject, Level.ERROR, text, remedy)
