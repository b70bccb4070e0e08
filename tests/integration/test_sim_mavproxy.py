"""The simulator and MAVProxy: run where ``mavproxy.py`` is installed, skipped elsewhere."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.integration.simulator import simulator

MAVPROXY = shutil.which("mavproxy.py", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
pytestmark = [
    pytest.mark.integration,
    pytest.mark.skipif(MAVPROXY is None, reason="mavproxy.py is not installed"),
]
MODULES = "link,wp,param,arm,mode,cmdlong,misc,output"  # others need a desktop or the internet
WAYPOINTS = """QGC WPL 110
0\t1\t3\t16\t0\t0\t0\t0\t47.397742\t8.545594\t488\t1
1\t0\t3\t22\t0\t0\t0\t0\t47.397742\t8.545594\t10\t1
2\t0\t3\t16\t0\t0\t0\t0\t47.397900\t8.545594\t12\t1
"""


class Console:
    """MAVProxy's command line: type, and wait for what it prints."""

    def __init__(self, port: int, folder: Path) -> None:
        self._output = folder / "output.txt"
        with self._output.open("w") as output:
            self.process = subprocess.Popen(
                [
                    str(MAVPROXY),
                    f"--master=udpin:127.0.0.1:{port}",
                    f"--default-modules={MODULES}",
                ],
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=subprocess.STDOUT,
                text=True,
                cwd=folder,
            )
        self._read = 0

    def type(self, line: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def wait(self, text: str, within_s: float = 20.0) -> None:
        """Until ``text`` was printed after what was waited for last."""
        end = time.monotonic() + within_s
        while (at := self._output.read_text().find(text, self._read)) < 0:
            assert time.monotonic() < end, f"no {text!r} in: {self._output.read_text()}"
            time.sleep(0.05)
        self._read = at + len(text)

    def close(self) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()  # the end of its input ends it
        try:
            self.process.wait(10)
        finally:
            self.process.kill()
            self.process.wait()


@pytest.mark.parametrize(
    ("face", "name", "default", "command", "mode"),
    [
        # its own "mode" command knows no numbers of PX4's
        (("--speed", "5"), "MIS_TAKEOFF_ALT", "2.5", "long DO_SET_MODE 1 4 4", "MISSION"),
        (
            ("--speed", "10", "--autopilot", "ardupilot"),
            *("RTL_ALT_FINAL", "0.0", "mode GUIDED", "GUIDED"),
        ),
    ],
    ids=["px4", "ardupilot"],
)
def test_parameters_waypoints_modes_and_arming(tmp_path, face, name, default, command, mode):
    (tmp_path / "wp.txt").write_text(WAYPOINTS)
    (tmp_path / "other.parm").write_text(f"{name} 7\n")
    with simulator(*face) as sim:
        console = Console(sim.port, tmp_path)
        try:
            console.wait("online system 1")
            console.wait("Received ")
            console.type(f"param show {name}")
            console.wait(name)
            console.wait(default)
            console.type(f"param set {name} 6")
            time.sleep(1)
            console.type(f"param show {name}")
            console.wait("6.0")
            console.type("param load other.parm")
            console.wait("Loaded 1 parameters from other.parm")
            console.type(f"param show {name}")
            console.wait("7.0")
            console.type("wp load wp.txt")
            console.wait("Sent all 3 waypoints")
            console.wait("ACCEPTED")
            time.sleep(3)  # it mixes up a list with a load before
            console.type("wp list")
            console.wait("22 3 47.3977420000 8.5455940000 10.000000")
            console.type(command)
            console.wait(f"Mode {mode}")
            console.type("arm throttle")
            console.wait("COMPONENT_ARM_DISARM: ACCEPTED")
        finally:
            console.close()
