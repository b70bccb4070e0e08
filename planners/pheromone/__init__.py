"""Digital pheromones: maps, detection and revisit, leaders and followers (Shao 2020).

Kernels with leading batch axes, in cells and steps. The planners over them are in
``planners.search.pheromone``.
"""

from planners.pheromone.detect import DetectRule, decide
from planners.pheromone.field import Field, spread, step, worn
from planners.pheromone.law import FieldLaw, PathLaw, SpreadLaw, Weights
from planners.pheromone.look import Look, look
from planners.pheromone.sectors import sector_means

__all__ = [
    "DetectRule",
    "Field",
    "FieldLaw",
    "Look",
    "PathLaw",
    "SpreadLaw",
    "Weights",
    "decide",
    "look",
    "sector_means",
    "spread",
    "step",
    "worn",
]
