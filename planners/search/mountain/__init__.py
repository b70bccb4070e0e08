"""Multi-target search in mountains: Zhou 2023, in pieces that other code can call.

Zhou, Zhou, Wang and Chen 2023, "Multitarget Search Algorithm Using Swarm Robots in an
Unknown 3D Mountain Environment", Appl. Sci. 13, 1969.
"""

from planners.search.mountain.alliance import rank_members, respond, signal
from planners.search.mountain.decide import Rules, decide
from planners.search.mountain.params import MountainParams
from planners.search.mountain.surface import advance, avoid_steep, ground_plane, track_surface

__all__ = [
    "MountainParams",
    "Rules",
    "advance",
    "avoid_steep",
    "decide",
    "ground_plane",
    "rank_members",
    "respond",
    "signal",
    "track_surface",
]
