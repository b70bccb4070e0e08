"""The place agents of a mission: where they stand, what they own."""

from __future__ import annotations

from uavbridge.config import Mission
from uavbridge.config.pheromones import Pheromones, tiles
from uavbridge.place.agent import Site


def sites_of(mission: Mission, table: Pheromones) -> tuple[Site, ...]:
    """All place agents, ascending ids; none where each UAV keeps a copy."""
    if table.form != "places":
        return ()
    grid, found = mission.grid, []
    for number, (place, tile) in enumerate(tiles(mission, table).items()):
        if table.positions:
            x, y = table.positions[number]
        else:
            x = grid.west_m + (tile.west + tile.east) / 2.0 * grid.cell_m
            y = grid.south_m + (tile.south + tile.north) / 2.0 * grid.cell_m
        found.append(Site(place, tile, (x, y, table.height_m)))
    return tuple(found)
