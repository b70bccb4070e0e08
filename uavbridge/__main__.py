"""``python -m uavbridge``: the command line."""

from uavbridge.cli import main

if __name__ == "__main__":
    main(prog_name="uavbridge")
