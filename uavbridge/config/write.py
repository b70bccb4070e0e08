"""A mission back into TOML, so that an agent elsewhere can load what this one was told."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from math import isinf, isnan
from typing import Any

from uavbridge.config.mission import Mission

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def to_toml(mission: Mission) -> str:
    """The mission as a TOML file that loads to an equal mission, every default spelt out."""
    lines = [f"{_key(key)} = {_value(value)}" for key, value in mission.plain().items()]
    return "\n".join(lines) + "\n"


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _text(key)


def _text(text: str) -> str:
    return json.dumps(text).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, float) and (isinf(value) or isnan(value)):
        return str(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(_value, value)) + "]"
    return repr(value)
