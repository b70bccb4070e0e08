"""Ctrl-C before a program has begun, and when it is at its end."""

import signal
import subprocess
import sys

import pytest

pytestmark = pytest.mark.integration
PROGRAM = """
import time
from sim_vehicles.loading import load_and_run

def wait():
    print("here", flush=True)
    time.sleep(60)

def program(prog_name):
    try:
        {during}
    finally:
        print("in order", flush=True)

def load():
    {loading}
    return program

try:
    load_and_run(load, "name")
finally:
    {after}
"""


@pytest.mark.parametrize("when", ["loading", "during", "after"])
def test_no_traceback_but_of_the_program_itself(when):
    steps = {"loading": "pass", "during": "pass", "after": "pass"} | {when: "wait()"}
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM.format(**steps)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if line == "here\n":
            break
    process.send_signal(signal.SIGINT)
    rest, errors = process.communicate(timeout=30)
    assert process.returncode == -signal.SIGINT
    assert ("in order" in rest, "KeyboardInterrupt" in errors) == (when == "during",) * 2
    assert when == "during" or not errors
