"""Makes a mission's certificates: a certificate authority of its own, an identity for each part."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from ipaddress import ip_address
from pathlib import Path
from typing import Final

import msgspec
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric.ec import SECP256R1, EllipticCurvePrivateKey
from cryptography.hazmat.primitives.asymmetric.ec import generate_private_key as generate
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat
from cryptography.x509.oid import NameOID

from uavbridge.bus import security
from uavbridge.clock import wall_date
from uavbridge.errors import ConfigError

LOCAL: Final = ("localhost", "127.0.0.1")
_BEFORE_S: Final = 3600.0  # clocks of other machines may be behind
_DAY_S: Final = 86400.0
_MOST_DAYS: Final = 36500.0
_LONGEST_NAME: Final = 64  # of a certificate's common name
_PRIVATE: Final = 0o600
_NAME: Final = re.compile(r"[A-Za-z0-9_*.-]{1,253}")


class _Authority:
    """Signs what a mission needs."""

    def __init__(self, mission: str, valid_s: float) -> None:
        self._valid_s = valid_s
        self._key = generate(SECP256R1())
        self._name = _named(f"uavbridge {mission}")
        self.certificate = self._builder(self._name, self._key, authority=True).sign(
            self._key, SHA256()
        )

    def issue(self, folder: Path, name: str, hosts: Sequence[x509.GeneralName] = ()) -> None:
        """Make one identity, in a folder of its own."""
        key = generate(SECP256R1())
        builder = self._builder(_named(name), key, authority=False)
        if hosts:
            alternatives = x509.SubjectAlternativeName(hosts)
            builder = builder.add_extension(alternatives, critical=False)
        folder.mkdir(parents=True)
        (folder / security.AUTHORITY).write_bytes(self.certificate.public_bytes(Encoding.PEM))
        certificate = builder.sign(self._key, SHA256())
        (folder / security.CERTIFICATE).write_bytes(certificate.public_bytes(Encoding.PEM))
        private = folder / security.PRIVATE_KEY
        private.touch(_PRIVATE)
        private.write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))

    def _builder(
        self, subject: x509.Name, key: EllipticCurvePrivateKey, *, authority: bool
    ) -> x509.CertificateBuilder:
        return (
            x509.CertificateBuilder()
            .subject_name(subject)
            .issuer_name(self._name)
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(wall_date(min(-_BEFORE_S, 2 * self._valid_s)))
            .not_valid_after(wall_date(self._valid_s))
            .add_extension(x509.BasicConstraints(ca=authority, path_length=None), critical=True)
        )


def make(
    folder: Path,
    mission: str,
    agents: Iterable[int],
    *,
    places: Iterable[int] = (),
    hosts: Sequence[str] = (),
    days: float = 30.0,
) -> list[Path]:
    """Make a folder of identities; the folders made.

    The authority's own key is thrown away: for other agents or after ``days`` make a new folder.

    Args:
        folder: must not be there yet.
        mission: name of the mission.
        agents: their ids.
        places: those of its place agents.
        hosts: names and addresses under which clients find the router, besides this machine's.
        days: how long the certificates are good; below 0: they are over, for tests.

    Raises:
        ConfigError: the folder is there already, or cannot be made; hosts or days make no sense.
    """
    if not abs(days) <= _MOST_DAYS:
        raise ConfigError(f"--days: must be at most {_MOST_DAYS:.0f}, not {days:g}")
    known = [_host(host) for host in (*LOCAL, *hosts)]
    access = security.Access(mission, sorted(agents), sorted(places))
    names = [
        security.ROUTER,
        security.LAUNCHER,
        security.OPERATOR,
        security.MONITOR,
        *map(security.agent_name, access.agents),
        *map(security.place_name, access.places),
    ]
    authority = _Authority(mission, days * _DAY_S)
    try:
        folder.mkdir(parents=True)
        for name in names:
            authority.issue(folder / name, name, known if name == security.ROUTER else ())
        (folder / security.ROUTER / security.ACCESS).write_bytes(msgspec.json.encode(access))
    except OSError as fault:
        raise ConfigError(f"{folder}: {fault.strerror}") from None
    return [folder / name for name in names]


def _named(name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name[:_LONGEST_NAME])])


def _host(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ip_address(host))
    except ValueError:
        if _NAME.fullmatch(host):
            return x509.DNSName(host)
    raise ConfigError(f"--host: {host!r} is neither an address nor a name of a machine")
