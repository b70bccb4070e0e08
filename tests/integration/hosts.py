"""Several machines on one: network namespaces on a bridge of their own."""

import os
import subprocess
from contextlib import ExitStack, contextmanager

import pytest

NETWORK = "10.77.3"


def address(number):
    """Of host ``number``, from 1."""
    return f"{NETWORK}.{number}"


def ip(*words, host=None):
    """Run ``ip``, on a host."""
    where = [] if host is None else ["-n", host]
    subprocess.run(["ip", *where, *map(str, words)], check=True, capture_output=True)


@contextmanager
def hosts(count):
    """Names of ``count`` connected hosts; skips the test where the machine lets nobody make any."""
    mark = f"uav{os.getpid()}"
    names = [f"{mark}-{number}" for number in range(1, count + 1)]
    switch = f"{mark}-s"
    with ExitStack() as stack:
        for name in (switch, *names):
            try:
                ip("netns", "add", name)
            except (OSError, subprocess.CalledProcessError) as error:
                pytest.skip(f"no network namespaces here: {getattr(error, 'stderr', error)}")
            stack.callback(ip, "netns", "del", name)
            ip("link", "set", "lo", "up", host=name)
        ip("link", "add", "bridge", "type", "bridge", host=switch)
        ip("link", "set", "bridge", "up", host=switch)
        for number, name in enumerate(names, 1):
            ip("link", "add", "eth0", "type", "veth", "peer", "name", f"to{number}", host=name)
            ip("link", "set", f"to{number}", "netns", switch, host=name)
            ip("link", "set", f"to{number}", "master", "bridge", "up", host=switch)
            ip("address", "add", f"{address(number)}/24", "dev", "eth0", host=name)
            ip("link", "set", "eth0", "up", host=name)
        yield names
