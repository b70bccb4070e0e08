"""The emulated radio: the one place that decides who hears whom, and when."""

from uavbridge.radio.quality import Link, Quality
from uavbridge.radio.queues import Queue
from uavbridge.radio.radio import Radio, Transmissions, Verdict

__all__ = ["Link", "Quality", "Queue", "Radio", "Transmissions", "Verdict"]
