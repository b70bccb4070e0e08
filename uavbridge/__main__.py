"""``uavbridge`` and ``python -m uavbridge``: the command line."""

from sim_vehicles.loading import Program, load_and_run


def _load() -> Program:
    from uavbridge.cli import main as program

    return program


def main() -> None:
    """Run the command line."""
    load_and_run(_load, "uavbridge")


if __name__ == "__main__":
    main()
