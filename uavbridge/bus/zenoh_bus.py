"""The live bus: a client session of a zenoh router, and the router itself.

The only file that imports zenoh. Samples wait in zenoh's own ring until they are
drained: no Python thread wakes up for them, so none can hang the exit, and a process
that stops reading loses the oldest instead of growing.
"""

from __future__ import annotations

import json
import logging
import os
import socket
from collections.abc import Callable, Sequence
from typing import Any, Self, TypeAlias

import zenoh
from zenoh import handlers

from uavbridge.bus import keys
from uavbridge.bus.api import Sample
from uavbridge.bus.matching import check
from uavbridge.bus.refusals import REFUSALS_LOG
from uavbridge.bus.security import Identity, access_control
from uavbridge.errors import BusError

PORT = 7447
LOOPBACK = "127.0.0.1"
MOST_PUBLISHERS = 4096  # keys kept declared; agents that fly over tiles use ever new ones
CAPACITY = 8192  # samples a subscription holds between two drains

Read: TypeAlias = Callable[[zenoh.Sample], bytes]

_log = logging.getLogger(__name__)

_SETTINGS: dict[str, Any] = {
    "scouting/multicast/enabled": False,
    "scouting/delay": 0,
    "timestamping/enabled": False,
    # a segment in /dev/shm outlives a killed process
    "transport/shared_memory/enabled": False,
    # a router that accepts but never answers
    "transport/unicast/open_timeout": 2000,
    # a frozen process is gone within two seconds
    "transport/link/tx/lease": 1500,
    "transport/link/tx/queue/size/data": 16,
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 5000,
}
# Whoever is frozen or too slow to listen must not hold up the rest: a router that waits long
# for one of its clients serves none of the others meanwhile. Microseconds.
_ROUTER: dict[str, Any] = {
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 200,
    "transport/link/tx/queue/congestion_control/block/wait_before_close": 200_000,
}
_TLS = "transport/link/tls"
_RETRY = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2}


class ZenohMailbox:
    """One subscription's samples, in order of arrival.

    Attributes:
        delivered: samples drained so far.
        overflows: drains that found the ring full, so that older samples may be lost.
    """

    def __init__(
        self,
        declare: Callable[[Any], Any],
        read: Read,
        skip: int,
        capacity: int,
    ) -> None:
        self.delivered = 0
        self.overflows = 0
        self._read = read
        self._skip = skip
        self._capacity = capacity
        self._subscriber = declare(handlers.RingChannel(capacity))
        self._left: list[Sample] = []

    def drain(self) -> list[Sample]:
        samples, self._left = self._left, []
        if self._subscriber is not None:
            self._take(samples)
        self.delivered += len(samples)
        return samples

    def close(self) -> None:
        if self._subscriber is None:
            return
        self._take(self._left)
        self._subscriber.undeclare()
        self._subscriber = None

    def _take(self, samples: list[Sample]) -> None:
        receive, read, skip = self._subscriber.try_recv, self._read, self._skip
        # bounded: a publisher faster than this loop must not hold it for ever
        for _ in range(self._capacity):
            sample = receive()
            if sample is None:
                return
            samples.append(Sample(str(sample.key_expr)[skip:], read(sample)))
        self.overflows += 1
        _log.warning("bus: %d samples were waiting, older ones may be lost", self._capacity)


def _payload(sample: zenoh.Sample) -> bytes:
    return sample.payload.to_bytes()


def _token(sample: zenoh.Sample) -> bytes:
    return b"1" if sample.kind == zenoh.SampleKind.PUT else b""


class ZenohBus:
    """A mission's bus as a client of a router.

    Puts made while the router is away are lost; the session finds it again by itself.

    Args:
        endpoint: the router's, such as ``"tcp/127.0.0.1:7447"``.
        mission: its name, part of every key.
        wait_s: how long to wait for a router that is not there yet.
        capacity: samples a subscription holds between two drains.
        identity: who this session is, where the router asks.

    Raises:
        BusError: no router answers at the endpoint, or it refuses the session.
    """

    def __init__(
        self,
        endpoint: str,
        mission: str,
        *,
        wait_s: float = 0.0,
        capacity: int = CAPACITY,
        identity: Identity | None = None,
    ) -> None:
        self.endpoint = endpoint
        self._prefix = keys.prefix(mission)
        self._capacity = capacity
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._kept: list[Any] = []  # queryables and tokens end when nobody holds them
        self._mailboxes: list[ZenohMailbox] = []
        try:
            self._session = zenoh.open(
                _config(
                    "client",
                    {
                        "connect/endpoints": [endpoint],
                        "connect/timeout_ms": round(wait_s * 1000),
                        "connect/retry": _RETRY,
                        **({} if identity is None else {_TLS: identity.connects()}),
                    },
                )
            )
        except zenoh.ZError as fault:
            why = _why(fault) or _refused(endpoint, identity)
            raise BusError(f"no zenoh router answers at {endpoint}{why}") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def connected(self) -> bool:
        """Whether the router is there right now."""
        return not self._session.is_closed() and bool(self._session.info.routers_zid())

    @property
    def delivered(self) -> int:
        """Samples drained from all mailboxes of this session."""
        return sum(mailbox.delivered for mailbox in self._mailboxes)

    def publish(self, key: str, data: bytes) -> None:
        publisher = self._publishers.get(key)
        if publisher is None:
            if len(self._publishers) == MOST_PUBLISHERS:
                self._publishers.clear()
            publisher = self._publishers[key] = self._publisher(key)
        try:
            publisher.put(data)
        except zenoh.ZError as fault:
            raise self._closed(fault) from None

    def subscribe(self, pattern: str) -> ZenohMailbox:
        expression = self._prefix + check(pattern)
        return self._mailbox(
            lambda ring: self._session.declare_subscriber(expression, ring), _payload
        )

    def watch(self, pattern: str) -> ZenohMailbox:
        expression = self._prefix + check(pattern)
        liveliness = self._session.liveliness()
        return self._mailbox(
            lambda ring: liveliness.declare_subscriber(expression, ring, history=True), _token
        )

    def serve(self, key: str, answer: Callable[[str], bytes | None]) -> None:
        expression = self._prefix + check(key)

        def reply(query: zenoh.Query) -> None:
            with query:
                data = answer(key)
                if data is not None:
                    query.reply(expression, data)

        # on zenoh's own thread: a Python thread per queryable would outlive a crash
        handler = handlers.Callback(reply, indirect=False)
        try:
            self._kept.append(self._session.declare_queryable(expression, handler))
        except zenoh.ZError as fault:
            raise self._closed(fault) from None

    def query(self, pattern: str, timeout_s: float = 1.0) -> list[Sample]:
        skip = len(self._prefix)
        try:
            replies = list(
                self._session.get(
                    self._prefix + check(pattern),
                    timeout=timeout_s,
                    target=zenoh.QueryTarget.ALL,
                    consolidation=zenoh.ConsolidationMode.NONE,
                )
            )
        except zenoh.ZError as fault:
            raise self._closed(fault) from None
        answers = [reply.ok for reply in replies if reply.ok is not None]
        return sorted(Sample(str(a.key_expr)[skip:], a.payload.to_bytes()) for a in answers)

    def declare(self, key: str) -> None:
        try:
            token = self._session.liveliness().declare_token(self._prefix + check(key))
        except zenoh.ZError as fault:
            raise self._closed(fault) from None
        self._kept.append(token)

    def missions(self) -> dict[str, list[int]]:
        """All missions of the router, by name, with the ids of their agents, ascending."""
        found: dict[str, list[int]] = {}
        replies = self._session.liveliness().get(keys.ALL_ALIVE)
        for key in sorted(str(reply.ok.key_expr) for reply in replies if reply.ok is not None):
            _, mission, _, agent = key.split("/")
            if agent.isdigit():
                found.setdefault(mission, []).append(int(agent))
        return {mission: sorted(agents) for mission, agents in found.items()}

    def close(self) -> None:
        self._session.close()  # type: ignore[no-untyped-call]

    def _publisher(self, key: str) -> zenoh.Publisher:
        space = keys.space_of(key)
        waits, urgent = (space.essential, space.urgent) if space else (False, False)
        control, priority = zenoh.CongestionControl, zenoh.Priority
        try:
            return self._session.declare_publisher(
                self._prefix + check(key),
                congestion_control=control.BLOCK if waits else control.DROP,
                priority=priority.INTERACTIVE_HIGH if urgent else priority.DATA,
            )
        except zenoh.ZError as fault:
            raise self._closed(fault) from None

    def _mailbox(self, declare: Callable[[Any], Any], read: Read) -> ZenohMailbox:
        try:
            mailbox = ZenohMailbox(declare, read, len(self._prefix), self._capacity)
        except zenoh.ZError as fault:
            raise self._closed(fault) from None
        self._mailboxes.append(mailbox)
        return mailbox

    def _closed(self, fault: zenoh.ZError) -> BusError:
        return BusError(f"zenoh session with {self.endpoint}: {_short(fault)}")


def find_missions(
    endpoint: str, *, wait_s: float = 0.0, identity: Identity | None = None
) -> dict[str, list[int]]:
    """The missions that a router knows, by name, each with the ids of its agents.

    Raises:
        BusError: no router answers at the endpoint, or it refuses the session.
    """
    with ZenohBus(endpoint, "any", wait_s=wait_s, identity=identity) as bus:
        return bus.missions()


class Router:
    """A zenoh router in this process.

    Args:
        listen: an endpoint such as ``"tcp/127.0.0.1:7447"``, or ``"auto"``: port 7447
            on loopback when it is free, else any free one.
        connect: endpoints of other routers; the missions of all are one.
        identity: the router's; it lets in whom its authority has signed, and everybody do
            what ``bus.security`` says. None: whoever comes may do everything.

    Attributes:
        endpoint: where clients find it.

    Raises:
        BusError: the port is in use, or the endpoint makes no sense.
    """

    def __init__(
        self,
        listen: str = "auto",
        *,
        connect: Sequence[str] = (),
        identity: Identity | None = None,
    ) -> None:
        settings = {**_linked(connect), **_guarded(identity)}
        if listen == "auto":
            protocol = "tcp" if identity is None else "tls"
            self.endpoint, self._session = _listen_anywhere(protocol, settings)
        else:
            self.endpoint, self._session = listen, _listen(listen, settings)

    def tell(self, mission: str, key: str, data: bytes) -> None:
        """Publish to all clients."""
        self._session.put(keys.prefix(mission) + check(key), data)

    @property
    def clients(self) -> int:
        """Sessions that are connected now."""
        return len(self._session.info.links())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop routing; clients wait for another."""
        self._session.close()  # type: ignore[no-untyped-call]


def log_refusals() -> None:
    """Have zenoh write on standard output whom its router refuses, for ``bus.refusals``."""
    os.environ["RUST_LOG"] = REFUSALS_LOG
    zenoh.init_log_from_env_or("error")


def _listen(endpoint: str, special: dict[str, Any]) -> zenoh.Session:
    settings = {**_ROUTER, "listen/endpoints": [endpoint], **special}
    try:
        return zenoh.open(_config("router", settings))
    except zenoh.ZError as fault:
        if "in use" in str(fault):
            raise BusError(f"zenoh router: {endpoint} is in use by another program") from None
        reason = _why(fault) or f": {_short(fault)}"
        raise BusError(f"zenoh router cannot listen on {endpoint}{reason}") from None


def _linked(connect: Sequence[str]) -> dict[str, Any]:
    """Other routers may come later: this one does not wait for them."""
    if not connect:
        return {}
    return {
        "connect/endpoints": list(connect),
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": _RETRY,
    }


def _guarded(identity: Identity | None) -> dict[str, Any]:
    if identity is None:
        return {}
    return {_TLS: identity.listens(), "access_control": access_control(identity.access())}


def _listen_anywhere(protocol: str, settings: dict[str, Any]) -> tuple[str, zenoh.Session]:
    ports = [PORT, *(_free_port() for _ in range(3))]
    for port in ports[:-1]:
        endpoint = f"{protocol}/{LOOPBACK}:{port}"
        try:
            return endpoint, _listen(endpoint, settings)
        except BusError as fault:
            _log.debug("%s", fault)
    endpoint = f"{protocol}/{LOOPBACK}:{ports[-1]}"
    return endpoint, _listen(endpoint, settings)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


def _config(mode: str, settings: dict[str, Any]) -> zenoh.Config:
    config = zenoh.Config()
    for key, value in {"mode": mode, **_SETTINGS, **settings}.items():
        config.insert_json5(key, json.dumps(value))
    return config


def _short(fault: zenoh.ZError) -> str:
    """What zenoh says, without the places in its source."""
    return str(fault).partition(" at /")[0].strip().rstrip("!.")


def _refused(endpoint: str, identity: Identity | None) -> str:
    """What may be behind a session that does not open: zenoh does not tell."""
    if identity is not None:
        return f", or it does not take {identity.folder} (expired, or of another mission?)"
    return " (tls: it wants an identity, --keys)" if endpoint.startswith("tls/") else ""


def _why(fault: zenoh.ZError) -> str:
    """What the endpoint has wrong, when it is that."""
    if "must be of the form" in str(fault):
        return ": an endpoint looks like tcp/127.0.0.1:7447"
    return ""
