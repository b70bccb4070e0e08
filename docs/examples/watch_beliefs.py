"""Print an agent's belief map while a mission flies, with plain zenoh.

python docs/examples/watch_beliefs.py [AGENT] [ENDPOINT] [MAPS]
"""

import contextlib
import json
import sys

import numpy as np
import zenoh


def show(data: bytes) -> None:
    agent, t_us, columns, rows = np.frombuffer(data, "<u4,<i8,<u4,<u4", 1, 4)[0].tolist()
    chance = np.frombuffer(data, "<f4", offset=48 + 8 * columns * rows).reshape(columns, rows)
    print(f"agent {agent} at {t_us / 1e6:.1f} s, north up:")
    print(chance.T[::-1].round(2), flush=True)


def main(agent: str = "1", endpoint: str = "tcp/127.0.0.1:7447", maps: str = "10") -> None:
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    key = f"uavbridge/*/state/{agent}/map"
    with zenoh.open(config) as session:
        newest = session.declare_subscriber(key, zenoh.handlers.RingChannel(1))
        for reply in session.get(key):  # what it knows by now
            show(reply.ok.payload.to_bytes())
        for _ in range(int(maps)):  # and what it learns
            show(newest.recv().payload.to_bytes())


if __name__ == "__main__":
    with contextlib.suppress(KeyboardInterrupt):
        main(*sys.argv[1:])
