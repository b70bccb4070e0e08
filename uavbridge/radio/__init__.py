"""The emulated radio: the one place that decides who hears whom."""

from uavbridge.radio.radio import Radio, Transmissions, Verdict

__all__ = ["Radio", "Transmissions", "Verdict"]
