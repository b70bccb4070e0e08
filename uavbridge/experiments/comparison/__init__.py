"""Planners on one mission, in three fidelities: ``uavbridge compare`` and ``reality-gap``."""
