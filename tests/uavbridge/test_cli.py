"""The command line, in process and as a real process."""

from __future__ import annotations

import io
import json
import logging
import os
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from rich.console import Console
from rich.live import Live

from uavbridge.cli import main
from uavbridge.cli.group import set_up_logging

ROOT = Path(__file__).parents[2]
PLUGIN = os.pathsep.join(
    map(str, (ROOT / "docs/examples/my_planner", ROOT / "tests/plugin_package"))
)
SMALL = 'name = "small"\n[area]\ncell_m = 50\ncolumns = 4\nrows = 4\n'


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, list(arguments), prog_name="uavbridge")


def run_process(*arguments: str, path: str = "") -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "uavbridge", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": path, "COLUMNS": "100"},
        check=False,
    )


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "m.toml"
    path.write_text(SMALL)
    return path


def add(mission: Path, text: str) -> str:
    mission.write_text(mission.read_text() + text)
    return str(mission)


def test_version_and_help() -> None:
    assert run("--version").output.startswith("uavbridge, version ")
    assert "launch" in run("--help").output


def test_warnings_go_above_a_live_view() -> None:
    shown = io.StringIO()
    console = Console(file=shown, force_terminal=True, width=80, height=24)
    set_up_logging(0)
    try:
        with Live("a picture", console=console, auto_refresh=False):
            logging.getLogger("uavbridge.runner").warning("all vehicles return")
    finally:
        logging.getLogger("uavbridge").handlers = []
    assert "warning: all vehicles return" in shown.getvalue()


def test_check_tells_what_it_understood() -> None:
    result = run("check")
    assert result.exit_code == 0
    for fact in ("liu2022", "esustpm", "1 km2", "hidden targets: 3", "x 200 m, y 500 m"):
        assert fact in result.stdout
    facts = json.loads(run("check", "--json", "--vehicles", "2").stdout)
    assert [agent["id"] for agent in facts["agents"]] == [1, 2]


@pytest.mark.parametrize("command", ["check", "launch"])
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[radio]\nrange_m = -1\n", r"m.toml:7: radio.range_m: must be > 0 \(got -1\)"),
        ("[raido]\n", r"m.toml:6: raido: unknown key; did you mean radio\?"),
        ("[[targets]]\nposition = [1, 900]\n", r"m.toml:7: targets\[0\].position: .*outside"),
        ("[area]\n", r"m.toml: is not valid TOML: .*line 6"),
    ],
)
def test_bad_missions(mission: Path, command: str, text: str, message: str) -> None:
    result = run(command, add(mission, text))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert re.fullmatch(rf"error: .*{message}.*\n", result.stderr), result.stderr


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--vehicles", "0"), "--vehicles: must be >= 1 (got 0)"),
        (("--planner", "nobody"), "--planner: no such planner"),
        (("--speed", "-1"), "--speed: must be > 0"),
        (("--speed", "nan"), "--speed: must be > 0 (got nan)"),
        (("--clock", "fast"), '--clock: must be one of "paced", "stepped"'),
        (("--duration", "0"), "--duration: must be > 0"),
        (("--router", "nowhere"), "--router: must be a zenoh endpoint"),
    ],
)
def test_bad_options(options: tuple[str, ...], message: str) -> None:
    result = run("launch", *options)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith(f"error: {message}")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("options", [("--vehicles", "many"), ("--nothing",), ("a", "b")])
def test_misuse(options: tuple[str, ...]) -> None:
    result = run("launch", *options)
    assert result.exit_code == 2
    assert "Error: " in result.stderr


def test_no_traceback_from_a_real_process(tmp_path: Path) -> None:
    done = run_process("launch", str(tmp_path / "none.toml"), "--json")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == f"error: {tmp_path / 'none.toml'}: no such mission file\n"


@pytest.mark.integration
def test_check_finds_a_port_in_use(mission: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        result = run("check", add(mission, f"[simulator]\nports = {port}\n"))
    assert result.exit_code == 2
    assert f"simulator.ports: UDP port {port} on 127.0.0.1: Address already in use" in result.stderr
    assert run("check", str(mission)).exit_code == 0
    assert run("check", str(mission), "--clock", "stepped").exit_code == 0


@pytest.mark.integration
def test_check_finds_a_router_that_is_not_there(mission: Path) -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{listener.getsockname()[1]}"
        result = run("check", str(mission), "--router", endpoint)
        assert result.exit_code == 2
        assert f"bus.router: no router at {endpoint}: Connection refused" in result.stderr
        listener.listen()
        assert run("check", str(mission), "--router", endpoint).exit_code == 0
        taken = run("check", add(mission, f'[bus]\nlisten = "{endpoint}"\n'))
    assert taken.exit_code == 2
    assert "bus.listen: TCP port" in taken.stderr


def test_planners_are_listed_with_units() -> None:
    result = run("planners")
    assert result.exit_code == 0
    for word in ("esustpm", "mower", "sweep", "speed_m_s", "m/s"):
        assert word in result.stdout
    listed = {planner["name"]: planner for planner in json.loads(run("planners", "--json").stdout)}
    assert {"esustpm", "random", "mower", "boids", "boids-guided", "sweep"} <= set(listed)
    for planner in listed.values():
        for parameter in planner["parameters"]:
            assert parameter["unit"], (planner["name"], parameter["name"])
            assert parameter["doc"], (planner["name"], parameter["name"])


def test_an_installed_package_brings_a_planner(mission: Path) -> None:
    assert "nearest-unseen" not in run_process("planners").stdout
    listed = run_process("planners", "--json", path=PLUGIN)
    assert "nearest-unseen" in [planner["name"] for planner in json.loads(listed.stdout)]
    text = add(mission, "[parameters]\nspeed_m_s = 4\n")
    checked = run_process("check", text, "--planner", "random", path=PLUGIN)
    assert checked.returncode == 0, checked.stderr
    mission.write_text('planner = "nearest-unseen"\n' + mission.read_text())
    checked = run_process("check", text, path=PLUGIN)
    assert "planner nearest-unseen" in checked.stdout
    unknown = run_process("check", text)
    assert unknown.returncode == 2
    assert "planner: no such planner" in unknown.stderr


def fake_package(folder: Path, entries: str, source: str) -> str:
    info = folder / "other-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[uavbridge.planners]\n{entries}\n")
    (folder / "other.py").write_text(source)
    return str(folder)


def test_a_broken_planner_is_left_out(tmp_path: Path) -> None:
    path = fake_package(
        tmp_path, "a = other:KIND\nb = nowhere:KIND\nc = other:TEXT", "TEXT = 'no planner'\n"
    )
    done = run_process("planners", "--json", path=path)
    assert done.returncode == 0
    assert "esustpm" in [planner["name"] for planner in json.loads(done.stdout)]
    warnings = done.stderr.splitlines()
    assert len(warnings) == 3
    assert all(line.startswith("warning: planner ") for line in warnings)
    assert "other:TEXT left out: is not a PlannerKind" in done.stderr


def test_a_package_that_fails_in_its_own_way_is_left_out(tmp_path: Path) -> None:
    path = fake_package(tmp_path, "a = other:KIND", "raise RuntimeError('no camera')\n")
    done = run_process("check", "--planner", "other", path=path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "planner other:KIND left out: RuntimeError: no camera" in done.stderr


def test_two_planners_of_one_name(tmp_path: Path) -> None:
    source = "from planners.registry import BUILTIN\nKIND = BUILTIN['random']\n"
    done = run_process("planners", path=fake_package(tmp_path, "x = other:KIND", source))
    assert done.returncode == 2
    assert done.stderr.startswith("error: planner random: from both built in and other:KIND")


def test_sim_is_the_simulators_own_command_line() -> None:
    help_text = run("sim", "--help")
    assert help_text.exit_code == 0
    assert "Usage: uavbridge sim" in help_text.stdout
    assert "--count" in help_text.stdout
    assert run("sim", "--count", "none").exit_code == 2


def test_schema_is_json() -> None:
    assert json.loads(run("schema").stdout)["title"] == "uavbridge mission file"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_scripts(shell: str) -> None:
    result = run("completion", shell)
    assert result.exit_code == 0
    assert "_UAVBRIDGE_COMPLETE" in result.stdout


def test_planner_names_are_completed() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "uavbridge"],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=ROOT,
        check=False,
        env={
            **os.environ,
            "_UAVBRIDGE_COMPLETE": "bash_complete",
            "COMP_WORDS": "uavbridge launch --planner esu",
            "COMP_CWORD": "3",
        },
    )
    assert done.stdout.strip() == "plain,esustpm"


@pytest.mark.parametrize(
    "arguments",
    [
        ["replay", "x", "--speed", "nan"],
        ["replay", "x", "--speed", "inf"],
        ["replay", "x", "--speed", "0"],
        ["replay", "x", "--verify", "--from", "nan"],
        ["replay", "x", "--verify", "--from", "-1"],
        ["command", "pause", "--timeout", "inf"],
        ["report", "x", "--out", ""],
    ],
)
def test_numbers_and_folders_that_cannot_be_are_told(arguments):
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 2
    assert "Invalid value" in done.output
