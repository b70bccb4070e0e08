"""Which planners there are: ours, and those that installed packages bring.

A package brings planners by entry points in the group ``uavbridge.planners``; each names a
``PlannerKind``.
"""

from __future__ import annotations

import logging
from importlib.metadata import EntryPoint, entry_points

from planners.planner import PlannerKind
from planners.registry import BUILTIN
from uavbridge.errors import ConfigError

GROUP = "uavbridge.planners"

_log = logging.getLogger(__name__)


def planners() -> dict[str, PlannerKind]:
    """All planners by name. One that does not load is logged as a warning and left out.

    Raises:
        ConfigError: two of them have one name.
    """
    found = dict(BUILTIN)
    source = dict.fromkeys(BUILTIN, "built in")
    for entry in sorted(entry_points(group=GROUP)):
        kind = _load(entry)
        if kind is None:
            continue
        if kind.name in found:
            raise ConfigError(
                f"planner {kind.name}: from both {source[kind.name]} and {entry.value}; "
                "uninstall or rename one"
            )
        found[kind.name] = kind
        source[kind.name] = entry.value
    return found


def broken() -> dict[str, str]:
    """Why entry points do not load: reason by entry point."""
    reasons = {entry.value: _reason(entry) for entry in entry_points(group=GROUP)}
    return {value: reason for value, reason in reasons.items() if reason}


def _load(entry: EntryPoint) -> PlannerKind | None:
    reason = _reason(entry)
    if reason:
        _log.warning("planner %s left out: %s", entry.value, reason)
        return None
    kind: PlannerKind = entry.load()
    return kind


def _reason(entry: EntryPoint) -> str:
    """Why an entry point does not load to a planner; empty when it does."""
    try:
        kind = entry.load()
    except Exception as error:  # noqa: BLE001 - whatever a package does, the others still work
        return f"{type(error).__name__}: {error}"
    return "" if isinstance(kind, PlannerKind) else "is not a PlannerKind"
