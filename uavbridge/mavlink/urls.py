"""Where vehicles are, from text: the spelling of pymavlink and that of MAVSDK.

| written | means |
| --- | --- |
| ``udpin:HOST:PORT``, ``udp:HOST:PORT``, ``udpin://HOST:PORT``, ``udp://:PORT`` | listen |
| ``udpout:HOST:PORT``, ``udpout://HOST:PORT`` | speak first |
| ``tcp:HOST:PORT``, ``tcp://HOST:PORT``, ``tcpout://HOST:PORT`` | TCP client |
| ``tcpin:HOST:PORT``, ``tcpin://HOST:PORT`` | TCP server |
| ``mcast:``, ``mcast:PORT``, ``mcast:GROUP:PORT`` | multicast |
| ``/dev/ttyUSB0,57600``, ``serial:/dev/ttyUSB0:57600``, ``serial:///dev/ttyUSB0:57600`` | serial |

``#7`` after any of them means the vehicle with system id 7 there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from ipaddress import AddressValueError, IPv4Address
from typing import Final, Literal, TypeAlias

from sim_vehicles.codec.signing import Seal
from uavbridge.errors import ConfigError
from uavbridge.mavlink.hub import Gate, Hub, LinkGate
from uavbridge.mavlink.link import Link
from uavbridge.mavlink.multicast import MulticastGate
from uavbridge.mavlink.serial import SerialLink, speeds
from uavbridge.mavlink.tcp import TcpLink
from uavbridge.mavlink.tcp_server import TcpGate
from uavbridge.mavlink.udp import UdpGate, UdpLink

Kind: TypeAlias = Literal["udpin", "udpout", "tcp", "tcpin", "mcast", "serial"]

_KINDS: Final[dict[str, Kind]] = {
    "udp": "udpin",
    "udpin": "udpin",
    "udpout": "udpout",
    "tcp": "tcp",
    "tcpout": "tcp",
    "tcpin": "tcpin",
    "mcast": "mcast",
    "serial": "serial",
}
_DEFAULT_PORT: Final[dict[Kind, int]] = {
    "udpin": 14540, "udpout": 14540, "tcp": 5760, "tcpin": 5760,
}  # fmt: skip
_LISTENING: Final = frozenset({"udpin", "tcpin"})
_ANY: Final = "0.0.0.0"  # what an empty host means to a listener
_GROUP, _GROUP_PORT = "239.255.145.50", 14550  # MAVLink's own
_BAUD: Final = 57600
_MOST_SYSTEMS: Final = 255


@dataclass(frozen=True, slots=True)
class Endpoint:
    """What a connection string means."""

    kind: Kind
    host: str  # or group, or device
    port: int = 0
    baud: int = 0  # of a serial device
    system: int | None = None  # the vehicle that is meant; None: whoever is there

    @property
    def place(self) -> Endpoint:
        """Without the system: one socket or device."""
        return replace(self, system=None)

    def __str__(self) -> str:
        number = self.baud if self.kind == "serial" else self.port
        vehicle = "" if self.system is None else f"#{self.system}"
        return f"{self.kind}:{self.host}:{number}{vehicle}"


def parse_url(url: str) -> Endpoint:
    """Read a connection string. Raises ConfigError naming it."""
    text, mark, digits = url.partition("#")
    if not mark:
        return _parse(url, text)
    number = _number(digits, _MOST_SYSTEMS)
    if not number:
        raise ConfigError(f"{url!r}: a system id is 1..{_MOST_SYSTEMS}, not {digits!r}")
    return replace(_parse(url, text), system=number)


def _parse(url: str, text: str) -> Endpoint:
    if text.startswith("/dev/"):
        return _serial(url, text)
    scheme, colon, rest = text.partition(":")
    kind = _KINDS.get(scheme.lower())
    if not colon or kind is None:
        raise ConfigError(
            f"{url!r}: unknown kind of link {scheme!r}; write one of "
            + ", ".join(f"{each}:HOST:PORT" for each in _KINDS if each not in ("mcast", "serial"))
            + ", mcast:GROUP:PORT, serial:DEVICE:BAUD"
        )
    if kind == "serial":
        return _serial(url, rest.removeprefix("//"))
    if kind == "mcast":
        return _multicast(url, rest.removeprefix("//"))
    mavsdk = rest.startswith("//")
    host, colon, digits = rest.removeprefix("//").rstrip("/").rpartition(":")
    if not colon and mavsdk:
        host, digits = digits, ""
    if mavsdk and not digits:
        digits = str(_DEFAULT_PORT[kind])
    port = _port(url, digits)
    if ":" in host or "/" in host:
        raise ConfigError(f"{url!r}: {host!r} is no host name or IPv4 address")
    if kind not in _LISTENING and (not host or port == 0):
        raise ConfigError(f"{url!r}: {kind} needs a host and a port")
    return Endpoint(kind, host or _ANY, port)


def _number(digits: str, most: int) -> int | None:
    """A whole number 0..most in plain digits; None for anything else."""
    plain = digits.isascii() and digits.isdigit() and len(digits) <= len(str(most))
    return int(digits) if plain and int(digits) <= most else None


def _port(url: str, digits: str) -> int:
    port = _number(digits, 65535)
    if port is None:
        raise ConfigError(f"{url!r}: the port must be a number 0..65535, not {digits!r}")
    return port


def _multicast(url: str, rest: str) -> Endpoint:
    host, _, digits = rest.rpartition(":")
    group = host or _GROUP
    try:
        multicast = IPv4Address(group).is_multicast
    except AddressValueError:
        multicast = False
    if not multicast:
        raise ConfigError(f"{url!r}: {group!r} is no multicast group (224.0.0.0 and up)")
    return Endpoint("mcast", group, (_port(url, digits) if digits else 0) or _GROUP_PORT)


def _serial(url: str, rest: str) -> Endpoint:
    device, mark, digits = rest.rpartition("," if "," in rest else ":")
    if not mark:
        device, digits = rest, str(_BAUD)
    baud = _number(digits, 10**7)
    if not device.startswith("/") or "\0" in device:
        raise ConfigError(f"{url!r}: {device!r} is no device such as /dev/ttyUSB0")
    if baud not in speeds():
        known = ", ".join(str(each) for each in speeds() if each >= 9600)
        raise ConfigError(f"{url!r}: no baud rate {digits!r}; known are {known}")
    return Endpoint("serial", device, baud=baud)


def open_link(url: str, system: int | None = None) -> Link:
    """Open the link that a connection string names, for one vehicle.

    Args:
        url: the connection string.
        system: who is to be answered on a link that listens; None: whoever is heard.

    Raises:
        ConfigError: the string is wrong.
        LinkError: the port is in use, or there is no way to the address.
    """
    endpoint = parse_url(url)
    wanted = endpoint.system or system
    if endpoint.kind == "udpin":
        return UdpLink.bind(endpoint.host, endpoint.port, wanted)
    if endpoint.kind in ("tcpin", "mcast") and wanted is not None:
        return open_hub(endpoint).channel(wanted)
    gate = _gate(endpoint)
    if not isinstance(gate, LinkGate):
        raise ConfigError(f"{url!r}: which vehicle? write its system id after it, as #1")
    return gate.link


def open_hub(endpoint: Endpoint, seal: Seal | None = None) -> Hub:
    """Open what an endpoint names for all vehicles there.

    Args:
        endpoint: of them.
        seal: signs and checks signatures; None: nothing is signed.

    Raises:
        LinkError: the port is in use, or there is no way to the address.
    """
    return Hub(_gate(endpoint), str(endpoint.place), seal)


def _gate(endpoint: Endpoint) -> Gate:
    host, port = endpoint.host, endpoint.port
    match endpoint.kind:
        case "udpin":
            return UdpGate(host, port)
        case "udpout":
            return LinkGate(UdpLink.connect(host, port))
        case "tcp":
            return LinkGate(TcpLink(host, port))
        case "tcpin":
            return TcpGate(host, port)
        case "mcast":
            return MulticastGate(host, port)
        case "serial":
            return LinkGate(SerialLink(host, endpoint.baud))
