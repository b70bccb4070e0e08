"""``sim-vehicles`` and ``python -m sim_vehicles``: the simulator alone."""

from sim_vehicles.loading import Program, load_and_run


def _load() -> Program:
    from sim_vehicles.command_line import main as program

    return program


def main(name: str = "sim-vehicles") -> None:
    """Run the simulator's command line."""
    load_and_run(_load, name)


if __name__ == "__main__":
    main("python -m sim_vehicles")
