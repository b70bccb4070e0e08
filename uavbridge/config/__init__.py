"""Mission files: strict TOML, read into frozen values."""

from uavbridge.config.load import load, override, parse
from uavbridge.config.mission import Mission
from uavbridge.config.schema import json_schema
from uavbridge.config.starts import Member
from uavbridge.config.write import to_toml

__all__ = ["Member", "Mission", "json_schema", "load", "override", "parse", "to_toml"]
