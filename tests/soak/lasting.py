"""``uavbridge`` with batteries that last for days: python -m tests.soak.lasting launch ...

A simulated multirotor's lasts for twenty minutes, and its parameters have no say in that.
"""

import sys

from sim_vehicles.dynamics import multirotor
from uavbridge.cli import main

CAPACITY_AH = 5200.0

if __name__ == "__main__":
    object.__setattr__(multirotor._DEFAULT.battery, "capacity_ah", CAPACITY_AH)
    sys.exit(main())
