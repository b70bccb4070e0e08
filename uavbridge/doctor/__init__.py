"""Looks before flying: ports, vehicles, router, clocks, versions; and says what to do."""

from uavbridge.doctor.examination import examine
from uavbridge.doctor.finding import Diagnosis, Finding

__all__ = ["Diagnosis", "Finding", "examine"]
