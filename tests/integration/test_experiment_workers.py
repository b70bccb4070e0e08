"""Experiments over processes and over a Dask cluster: the same numbers."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from uavbridge.clock import pause
from uavbridge.experiments import output, registry, runner, spread

pytestmark = pytest.mark.integration
children_are_known = pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="children are read from /proc"
)


def numbers(who):
    experiment = registry.find("liu-table2")
    values = {"methods": "mower,esustpm", "cycles": 10}
    return output.as_json(runner.run(experiment, who, runs=120, values=values).rows)


def test_the_same_numbers_with_one_and_two_workers():
    assert numbers(spread.choose(1)) == numbers(spread.choose(2))


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_the_same_numbers_on_a_dask_cluster():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        address = cluster.scheduler_address
        assert numbers(spread.choose(1, dask=address)) == numbers(spread.Here())


def wait_for_workers(pid, count):
    """Until the process has at least ``count`` children."""
    for _ in range(600):
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        if len(children) >= count:
            return
        pause(0.05)
    raise AssertionError("no workers")


def anybody_left(group):
    """Whether processes of a group still run after a while."""
    for _ in range(200):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        pause(0.05)
    return True


@contextmanager
def at_work():
    """An experiment of minutes with two workers that are there."""
    arguments = ("experiment", "liu-table2", "--runs", "5000", "--workers", "2")
    process = subprocess.Popen(
        [sys.executable, "-m", "uavbridge", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        wait_for_workers(process.pid, 2)
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


@children_are_known
def test_an_interrupt_ends_all_processes():
    with at_work() as process:
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=30)
        assert process.returncode != 0
        assert "Traceback" not in err
        assert out == ""
        assert not anybody_left(process.pid)


@children_are_known
def test_workers_end_with_a_killed_parent():
    with at_work() as process:
        pause(1.0)  # in the middle of a task
        process.kill()
        process.wait()
        assert not anybody_left(process.pid)
