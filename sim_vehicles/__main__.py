"""``sim-vehicles`` and ``python -m sim_vehicles``: the simulator alone."""

from __future__ import annotations

from sim_vehicles.loading import load_and_run

TYPE_CHECKING = False
if TYPE_CHECKING:
    from sim_vehicles.loading import Program


def _load() -> Program:
    from sim_vehicles.command_line import main as program

    return program


def main(name: str = "sim-vehicles") -> None:
    """Run the simulator's command line."""
    load_and_run(_load, name)


if __name__ == "__main__":
    main("python -m sim_vehicles")
