"""``uavbridge`` and ``python -m uavbridge``: the command line."""

from __future__ import annotations

from sim_vehicles.loading import load_and_run

TYPE_CHECKING = False
if TYPE_CHECKING:
    from sim_vehicles.loading import Program


def _load() -> Program:
    from uavbridge.cli import main as program

    return program


def main() -> None:
    """Run the command line."""
    load_and_run(_load, "uavbridge")


if __name__ == "__main__":
    main()
