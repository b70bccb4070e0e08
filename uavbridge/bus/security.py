"""Who may do what on a mission's bus: identities on disk, and the router's rules.

``uavbridge keys new`` makes a folder with one identity in each sub-folder: ``ca.pem`` (whom to
believe), ``cert.pem`` and ``key.pem`` (who one is: the certificate's common name). The router
lets an identity write its own keys alone:

| identity | writes | hears |
| --- | --- | --- |
| ``agent-N`` | ``air/*/*/N``, ``safety/*/*/N``, ``place/air/*/*/N``, ``state/N/**``, ``pace/N``, ``layer/*/N`` | frames, beacons, its readings and orders, ``world/`` but for the mission's targets |
| ``place-N`` | ``place/air/*/*/N``, ``place/net/*``, ``layer/*`` | ``place/``, reports, ``world/truth``, ``world/run`` |
| ``launcher`` | everything | everything |
| ``operator`` | ``cmd/**`` | everything |
| ``monitor`` | nothing | everything |
"""  # noqa: E501 - a table

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from uavbridge.bus import keys
from uavbridge.errors import ConfigError

LAUNCHER, OPERATOR, MONITOR, ROUTER = "launcher", "operator", "monitor", "router"
AUTHORITY, CERTIFICATE, PRIVATE_KEY = "ca.pem", "cert.pem", "key.pem"
ACCESS = "access.json"  # in the router's folder: whom it serves

_PART = re.compile(rf"{LAUNCHER}|{OPERATOR}|{MONITOR}|{ROUTER}|(agent|place)-\d+")

_WRITE = ["put", "delete", "declare_queryable", "reply", "liveliness_token"]
_HEAR = ["declare_subscriber", "query", "liveliness_query", "declare_liveliness_subscriber"]


def agent_name(agent: int) -> str:
    """The identity of an agent."""
    return f"agent-{agent}"


def place_name(place: int) -> str:
    """The identity of a place agent."""
    return f"place-{place}"


class Access(msgspec.Struct, frozen=True):
    """Whom a router serves."""

    mission: str
    agents: list[int]
    places: list[int] = []


@dataclass(frozen=True, slots=True)
class Identity:
    """One folder of credentials.

    Raises:
        ConfigError: a file is missing.
    """

    folder: Path

    def __post_init__(self) -> None:
        for name in (AUTHORITY, CERTIFICATE, PRIVATE_KEY):
            if not (self.folder / name).is_file():
                raise ConfigError(f"{self.folder / name}: no such file (uavbridge keys new)")

    @property
    def whose(self) -> str | None:
        """The part that it was made for, by the folder's name; None: the folder was renamed."""
        name = self.folder.resolve().name
        return name if _PART.fullmatch(name) else None

    def connects(self) -> dict[str, Any]:
        """Zenoh's TLS settings of a client."""
        return {
            "root_ca_certificate": str(self.folder / AUTHORITY),
            "connect_certificate": str(self.folder / CERTIFICATE),
            "connect_private_key": str(self.folder / PRIVATE_KEY),
            "enable_mtls": True,
        }

    def listens(self) -> dict[str, Any]:
        """Zenoh's TLS settings of a router; it also is a client of other routers."""
        return {
            **self.connects(),
            "listen_certificate": str(self.folder / CERTIFICATE),
            "listen_private_key": str(self.folder / PRIVATE_KEY),
            "close_link_on_expiration": True,
        }

    def access(self) -> Access:
        """Whom the router of this folder serves.

        Raises:
            ConfigError: it is no router's folder.
        """
        path = self.folder / ACCESS
        try:
            return msgspec.json.decode(path.read_bytes(), type=Access)
        except OSError as fault:
            raise ConfigError(f"{path}: cannot be read: {fault.strerror}") from None
        except msgspec.DecodeError as fault:
            raise ConfigError(f"{path}: {fault}") from None


@dataclass(frozen=True, slots=True)
class _Role:
    """What one identity may do."""

    name: str
    writes: tuple[str, ...]
    hears: tuple[str, ...]


def _roles(agents: Iterable[int], places: Iterable[int]) -> list[_Role]:
    everything = ("**",)
    return [
        _Role(LAUNCHER, everything, everything),
        _Role(ROUTER, everything, everything),
        _Role(OPERATOR, (keys.cmd("*"),), everything),
        _Role(MONITOR, (), everything),
        *(
            _Role(
                agent_name(agent),
                (
                    keys.air(("*", "*"), agent),
                    keys.safety(("*", "*"), agent),
                    keys.place(("*", "*"), agent),
                    keys.state(agent),
                    f"{keys.state(agent)}/**",
                    keys.pace(agent),
                    keys.layer("*", agent),
                    keys.alive(agent),
                    f"layer/*/{agent}",
                ),
                (
                    "air/**",
                    "safety/**",
                    "place/**",
                    keys.obs(agent),
                    keys.cmd(),
                    keys.cmd(agent),
                    keys.TRUTH,
                    keys.BRIEFING,
                    keys.RUN,
                    keys.state_cells(agent),  # whether anybody else answers for it
                ),
            )
            for agent in agents
        ),
        *(
            _Role(
                place_name(place),
                # neighbours are told under their own keys
                (keys.place(("*", "*"), place), keys.place_net("*"), keys.layer("*")),
                ("place/**", keys.state("*"), keys.TRUTH, keys.RUN),
            )
            for place in places
        ),
    ]


def access_control(access: Access) -> dict[str, Any]:
    """Zenoh's ``access_control``: what is not allowed is refused."""
    prefix = keys.prefix(access.mission)
    roles = _roles(access.agents, access.places)
    rules: list[dict[str, Any]] = [
        _rule("deliver", "egress", [*_WRITE, *_HEAR], ["**"]),
        _rule("missions", "ingress", _HEAR, [keys.ALL_ALIVE]),
    ]
    policies = []
    for role in roles:
        allowed = ["deliver", "missions"]
        for what, messages, patterns in (("w", _WRITE, role.writes), ("h", _HEAR, role.hears)):
            if patterns:
                name = f"{role.name}-{what}"
                rules.append(_rule(name, "ingress", messages, [prefix + p for p in patterns]))
                allowed.append(name)
        policies.append({"subjects": [role.name], "rules": allowed})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": role.name, "cert_common_names": [role.name]} for role in roles],
        "policies": policies,
    }


def _rule(
    name: str, flow: str, messages: Sequence[str], expressions: Sequence[str]
) -> dict[str, Any]:
    return {
        "id": name,
        "permission": "allow",
        "flows": [flow],
        "messages": list(messages),
        "key_exprs": list(expressions),
    }
