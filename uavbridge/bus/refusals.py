"""Whom a router refused, read from zenoh's own log: it has no other way to tell.

A line of its log may be a refusal, or a look ahead: for each new key zenoh works out and logs
what a session might do with it. Those lines are told apart by their place.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import NamedTuple

REFUSALS_LOG = (
    "error,zenoh::net::routing::interceptor::access_control=trace,zenoh_link_tls::unicast=warn"
)

_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_AHEAD = re.compile(r"(ThreadId\(\d+\)).*ACL \((\w+)\): caching permissions for `(.+)`")
_ACT = re.compile(
    r"(ThreadId\(\d+\)).*access_control: (Using cached result: )?([0-9a-f]+)(?: on (\S+))? "
    r"is (un)?authorized to (.+) \((\w+)\) on (\S+)"
)
_NAME = re.compile(r"CertCommonName\(([^)]*)\)")
_HANDSHAKE = re.compile(r"zenoh_link_tls::unicast: (.*)")
_CONSIDERED = 9  # lines of one look ahead


class Refusal(NamedTuple):
    """One kind of thing that was refused."""

    who: str  # the certificate's name; empty: did not get that far
    what: str  # what was tried: "Put", ..., or why the session did not open
    key: str  # empty for sessions


class RefusalLog:
    """Counts refusals in zenoh's log.

    Attributes:
        counts: refusals so far.
    """

    def __init__(self) -> None:
        self.counts: Counter[Refusal] = Counter()
        self._names: dict[str, str] = {}  # session -> name
        self._ahead: dict[tuple[str, str, str], int] = {}  # lines left of looks ahead

    def feed(self, line: str) -> Refusal | None:
        """One line; what it says was refused."""
        line = _COLOUR.sub("", line)
        if ahead := _AHEAD.search(line):
            thread, flow, key = ahead.groups()
            self._ahead[thread, flow, key] = _CONSIDERED
            return None
        if act := _ACT.search(line):
            refusal = self._act(act)
        elif (said := _HANDSHAKE.search(line)) and " WARN " in line:
            why = said.group(1).split(" Hint:")[0].rstrip(".")
            refusal = Refusal("", why.split(": verification time")[0], "")
        else:
            return None
        if refusal is not None:
            self.counts[refusal] += 1
        return refusal

    def _act(self, act: re.Match[str]) -> Refusal | None:
        thread, cached, session, subject, refused, what, flow, key = act.groups()
        if subject and (name := _NAME.search(subject)):
            self._names[session] = name.group(1)
        if not cached and (left := self._ahead.get((thread, flow, key), 0)):
            if left == 1:
                del self._ahead[thread, flow, key]
            else:
                self._ahead[thread, flow, key] = left - 1
            return None
        if not refused or flow != "ingress":
            return None
        return Refusal(self._names.get(session, session), what, key)
