"""``python -m uavbridge.monitor.web ROUTER MISSION HOST PORT``: the page beside a launcher."""

import sys

from uavbridge.errors import UavbridgeError
from uavbridge.monitor.web.pages import child

try:
    child(sys.argv[1:])
except UavbridgeError as fault:
    sys.exit(f"error: {fault}")
