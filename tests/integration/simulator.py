"""The simulator as a process of its own."""

import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

COMMAND = [sys.executable, "-m", "sim_vehicles"]


@dataclass
class Simulator:
    """A running simulator; ``summary`` is its last line once it ended."""

    process: subprocess.Popen[str]
    port: int
    table: list[str]
    summary: str = ""


def free_port(kind: socket.SocketKind = socket.SOCK_DGRAM) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def simulator(*arguments: str, port: int | None = None) -> Iterator[Simulator]:
    """Start it, wait for its table, and end it as Ctrl-C would; its first id is 1."""
    port = free_port() if port is None else port
    process = subprocess.Popen(
        [*COMMAND, "--port", str(port), "--start-system", "1", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert process.stdout is not None
    try:
        table = []
        for line in process.stdout:
            table.append(line.rstrip())
            if "Ctrl-C ends" in line:
                break
        running = Simulator(process, port, table)
        yield running
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=10)
        assert process.returncode == 0, rest
        assert "Traceback" not in rest
        running.summary = rest.strip().splitlines()[-1]
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()
        process.stdout.close()
