"""``python -m uavbridge`` is the command ``uavbridge``."""

from uavbridge.cli import main

if __name__ == "__main__":
    main(prog_name="uavbridge")
