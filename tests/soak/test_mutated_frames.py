"""A million damaged frames at an agent's radio: no exception, no growth."""

import gc
import resource

import numpy as np
import pytest

from planners.grid import Grid
from tests.uavbridge.agent.swarm import Swarm
from uavbridge.bus.air import Air
from uavbridge.bus.local import LocalHub
from uavbridge.bus.screening import Bounds
from uavbridge.bus.wire import encode
from uavbridge.radio import Radio
from uavbridge.rng import stream

pytestmark = pytest.mark.soak

FRAMES = 1_000_000
BATCH = 2000
SECOND = 1_000_000


def honest():
    """Frames of a team with cells and probes, as bytes."""
    swarm = Swarm(4, "counts", Grid(0, 0, 100, 10, 10), frame_bytes=400.0)
    data = []
    for tick in range(40):
        swarm.observe(tick % 4, 7 * tick, tick % 3 == 0)
        swarm.exchange(lambda a, b: (1,) if (a + b) % 3 else ())
        data += [encode(frame) for _, frame in swarm._due.get(swarm.tick, ())]
    return data


def mutants(originals, rng, count):
    """Damaged copies: bytes changed, cut, or put together."""
    picks = rng.integers(0, len(originals), count)
    kinds = rng.integers(0, 4, count)
    for pick, kind in zip(picks.tolist(), kinds.tolist(), strict=True):
        data = bytearray(originals[pick])
        for place, value in rng.integers(0, 256, (1 + kind, 2)).tolist():
            data[place % len(data)] = value
        if kind == 3:
            del data[int(rng.integers(0, len(data))) :]
        yield bytes(data)


def test_they_change_nothing_and_are_not_kept():
    rng, originals = stream(1, "mutants"), honest()
    hub = LocalHub()
    bus = hub.bus()
    bounds = Bounds(team=(0, 1, 2, 3), mission=0, most_bytes=400, area=(0, 0, 1000, 1000), old_s=60)
    air = Air(hub.bus(), Radio(np.inf), [1, 2], bounds=bounds)
    mind, _ = Swarm(2, "counts", Grid(0, 0, 100, 10, 10)).minds[1]
    places = {1: (0.0, 0.0, 0.0), 2: (0.0, 0.0, 0.0)}
    heard, sizes = 0, []
    for batch in range(FRAMES // BATCH):
        for data in mutants(originals, rng, BATCH):
            bus.publish(f"air/0/0/{data[6] if len(data) > 6 else 0}", data)
        frames = air.receive(places, 60 * SECOND)[1]
        heard += len(frames)
        mind.merge(frames)
        mind.tell(batch, 400.0)
        if batch % 50 == 20:
            gc.collect()
            sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    assert heard > 0
    assert air.rejects.total() + heard <= FRAMES
    probability = mind.belief.probability
    assert ((probability > 0) & (probability < 1)).all()
    assert sizes[-1] - sizes[1] < 20_000  # kB
