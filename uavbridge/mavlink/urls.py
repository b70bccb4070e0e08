"""Links from text: the spelling of pymavlink and that of MAVSDK.

| written | means |
| --- | --- |
| ``udpin:HOST:PORT``, ``udp:HOST:PORT``, ``udpin://HOST:PORT``, ``udp://:PORT`` | listen |
| ``udpout:HOST:PORT``, ``udpout://HOST:PORT`` | speak first |
| ``tcp:HOST:PORT``, ``tcp://HOST:PORT``, ``tcpout://HOST:PORT`` | TCP client |
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from uavbridge.errors import ConfigError
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.tcp import TcpLink
from uavbridge.mavlink.udp import UdpLink

Kind: TypeAlias = Literal["udpin", "udpout", "tcp"]

_KINDS: dict[str, Kind] = {
    "udp": "udpin",
    "udpin": "udpin",
    "udpout": "udpout",
    "tcp": "tcp",
    "tcpout": "tcp",
}
_DEFAULT_PORT: dict[Kind, int] = {"udpin": 14540, "udpout": 14540, "tcp": 5760}
_ANY = "0.0.0.0"  # what an empty host means to a listener


@dataclass(frozen=True, slots=True)
class Endpoint:
    """What a connection string means."""

    kind: Kind
    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.kind}:{self.host}:{self.port}"


def parse_url(url: str) -> Endpoint:
    """Read a connection string. Raises ConfigError naming it."""
    scheme, colon, rest = url.partition(":")
    kind = _KINDS.get(scheme.lower())
    if not colon or kind is None:
        raise ConfigError(
            f"{url!r}: unknown kind of link {scheme!r}; write one of "
            + ", ".join(f"{each}:HOST:PORT" for each in _KINDS)
        )
    mavsdk = rest.startswith("//")
    host, colon, digits = rest.removeprefix("//").rstrip("/").rpartition(":")
    if not colon and mavsdk:
        host, digits = digits, ""
    if mavsdk and not digits:
        digits = str(_DEFAULT_PORT[kind])
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 5 and int(digits) <= 65535):
        raise ConfigError(f"{url!r}: the port must be a number 0..65535, not {digits!r}")
    if ":" in host or "/" in host:
        raise ConfigError(f"{url!r}: {host!r} is no host name or IPv4 address")
    if kind != "udpin" and (not host or int(digits) == 0):
        raise ConfigError(f"{url!r}: {kind} needs a host and a port")
    return Endpoint(kind, host or _ANY, int(digits))


def open_link(url: str, system: int | None = None) -> Link:
    """Open the link that a connection string names.

    Args:
        url: the connection string.
        system: who is to be answered on a link that listens; None: whoever is heard.

    Raises:
        ConfigError: the string is wrong.
        LinkError: the port is in use, or there is no way to the address.
    """
    endpoint = parse_url(url)
    if endpoint.kind == "udpin":
        return UdpLink.bind(endpoint.host, endpoint.port, system)
    if endpoint.kind == "udpout":
        return UdpLink.connect(endpoint.host, endpoint.port)
    return TcpLink(endpoint.host, endpoint.port)
