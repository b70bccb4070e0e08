"""Mission files: what they mean, and how they fail."""

from __future__ import annotations

import json
import re
import tomllib
from importlib.resources import files
from math import hypot, inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.grid import Grid
from uavbridge import config
from uavbridge.config import Mission
from uavbridge.config.schema import json_schema
from uavbridge.config.starts import lattice
from uavbridge.errors import ConfigError

EXAMPLE = (files("uavbridge") / "missions" / "liu2022.toml").read_text()
SMALL = 'name = "small"\n[area]\ncell_m = 50\ncolumns = 4\nrows = 4\n'


def small(more: str = "", **overrides: object) -> Mission:
    return config.parse(more + SMALL if "[" not in more else SMALL + more, "m.toml", overrides)


def edited(old: str, new: str) -> str:
    assert old in EXAMPLE
    return EXAMPLE.replace(old, new, 1)


def test_the_example_is_lius_scenario() -> None:
    mission = config.load()
    assert mission.planner == "esustpm"
    assert mission.grid == Grid(0.0, 0.0, 100.0, 10, 10)
    assert mission.target_cells() == ((4, 5), (4, 7), (7, 5))
    scenario = mission.scenario()
    assert scenario.team == tuple(range(1, 11))
    starts = [(x, y, 40.0) for x in (100.0, 200.0) for y in (100.0, 200.0, 300.0, 400.0, 500.0)]
    assert scenario.starts.tolist() == [list(start) for start in starts]
    assert scenario.radio_range_m == 400.0
    assert scenario.detection_threshold == 0.95
    assert (mission.sensor.p, mission.sensor.q, mission.belief.prior) == (0.9, 0.05, 0.5)
    assert (mission.clock, mission.speed, mission.duration) == ("paced", 10.0, 900.0)


def test_where_targets_are_expected_the_map_begins_higher() -> None:
    assert (small().prior() == 0.5).all()
    more = "[belief]\nprior = 0.1\npeak = 0.6\nexpected = [{ position = [75, 125] }]\n"
    expecting = small(more).prior()
    assert np.unravel_index(expecting.argmax(), expecting.shape) == (1, 2)
    assert expecting.max() == 0.6
    assert expecting.min() >= 0.1
    assert small(more.replace("0.6", "0.1")).prior() == pytest.approx(0.1)


def test_defaults_are_enough_for_a_small_mission() -> None:
    mission = small()
    assert mission.vehicles == 1
    assert mission.radio.range_m == inf
    assert mission.coverage_goal == 0.9
    assert mission.tick == 1.0


def test_agents_do_not_see_targets() -> None:
    mission = config.load()
    told = mission.for_agents()
    assert told.targets == ()
    assert told.scenario().starts.tolist() == mission.scenario().starts.tolist()
    text = config.to_toml(told)
    assert "targets = []" in text
    assert config.parse(text) == told


def test_agents_do_not_see_columns_that_they_are_to_find() -> None:
    row = "[[obstacles]]\nposition = [50, 60]\nradius_m = 5\nknown = {}\n"
    mission = small(row.format("false") + row.format("true"))
    assert [each.known for each in mission.for_agents().obstacles] == [True]


def test_who_sees_columns_too_late_to_stop_is_refused() -> None:
    row = "[[obstacles]]\nposition = [50, 60]\nradius_m = 5\n"
    with pytest.raises(ConfigError, match=r"sensor\.sight_m.*48 m"):
        small("[sensor]\nsight_m = 40\n" + row)
    small("[sensor]\nsight_m = 40\n" + row + "known = true\n")


def test_toml_round_trip() -> None:
    mission = small(
        '[radio]\nrange_m = inf\n[bus]\nrouter = "tcp/[::1]:7447"\n'
        "[simulator.parameters]\nMPC_XY_VEL_MAX = 12\n[[agents]]\nid = 7\nstart = [3, 4.5]\n"
    )
    assert config.parse(config.to_toml(mission)) == mission


@pytest.mark.parametrize("name", ["fréquence\n\"quoted\" 'x' \\ \x7f \u2028", "", "\t\0"])
def test_any_string_survives_toml(name: str) -> None:
    mission = small("", out=name)
    assert config.parse(config.to_toml(mission)).out == name


def test_options_replace_keys() -> None:
    mission = config.load(None, {"vehicles": 3, "seed": 8, "bus.router": "tcp/x:1", "out": None})
    assert (mission.vehicles, mission.seed, mission.bus.router) == (3, 8, "tcp/x:1")
    assert mission.scenario().team == (1, 2, 3)
    assert config.override(mission, {"radio.range_m": 50.0}).radio.range_m == 50.0


def test_parameters_belong_to_the_files_planner() -> None:
    text = edited("[parameters]", "[parameters]\nguide_gain = 1.0")
    assert config.parse(text, overrides={"planner": "esustpm"}).parameters == {"guide_gain": 1.0}
    assert config.parse(text, overrides={"planner": "random"}).parameters == {}


def test_a_mission_comes_from_its_file(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text(EXAMPLE)
    assert config.load(path) == config.load()


class TestTeam:
    def test_more_vehicles_than_starts(self) -> None:
        team = config.load(None, {"vehicles": 60}).team()
        points = [member.start for member in team]
        assert points[:10] == [member.start for member in config.load().team()]
        assert len(set(points)) == 60
        nearest = min(hypot(a[0] - b[0], a[1] - b[1]) for a in points for b in points if a != b)
        assert nearest >= 100.0 - 1e-6

    def test_listed_agents_come_first(self) -> None:
        mission = small(
            "[[agents]]\nid = 42\nstart = [10, 20]\n[[agents]]\nid = 2\naltitude_m = 55\n",
            vehicles=4,
        )
        team = {member.id: member for member in mission.team()}
        assert list(team) == [1, 2, 3, 42]
        assert team[42].start == (10.0, 20.0)
        assert team[2].altitude_m == 55.0
        assert team[1].altitude_m == 40.0
        assert [m.id for m in small("[[agents]]\nid = 42\n[[agents]]\nid = 2\n").team()] == [2, 42]

    @given(
        columns=st.integers(1, 12),
        rows=st.integers(1, 12),
        cell=st.sampled_from([10.0, 33.3, 100.0]),
        spacing=st.floats(5.0, 200.0),
        taken=st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), max_size=5),
        count=st.integers(0, 40),
    )
    def test_lattice(
        self,
        columns: int,
        rows: int,
        cell: float,
        spacing: float,
        taken: list[tuple[float, float]],
        count: int,
    ) -> None:
        grid = Grid(-20.0, 30.0, cell, columns, rows)
        west, south, east, north = grid.bounds
        given_points = [(west + u * (east - west), south + v * (north - south)) for u, v in taken]
        try:
            points = lattice(grid, given_points, spacing, count)
        except ValueError:
            assert (count + len(taken)) * spacing**2 > grid.size * cell**2 / 10
            return
        assert len(points) == count
        assert all(west <= x <= east and south <= y <= north for x, y in points)
        for index, point in enumerate(points):
            for other in [*points[:index], *given_points]:
                assert hypot(point[0] - other[0], point[1] - other[1]) >= spacing - 1e-5


# Each: what to put in the place of what in the example, the key named, a word of the message.
WRONG = [
    ("cell_m = 100", "cel_m = 100", "area.cel_m", "did you mean cell_m"),
    ("[area] ", "[aera] ", "aera", "did you mean area"),
    ("cell_m = 100", 'cell_m = "wide"', "area.cell_m", "must be a number"),
    ("cell_m = 100", "cell_m = 0", "area.cell_m", "> 0"),
    ("cell_m = 100", "cell_m = nan", "area.cell_m", "got nan"),
    ("columns = 10", "columns = 10.5", "area.columns", "whole number"),
    ("columns = 10", "", "area.columns", "missing"),
    ("range_m = 400", "range_m = -400", "radio.range_m", "got -400"),
    ("range_m = 400", "range_m = nan", "radio.range_m", "nan"),
    ("p = 0.9 ", "p = 1.0 ", "sensor.p", "< 1"),
    ("q = 0.05", "q = 0.0", "sensor.q", "> 0"),
    ("q = 0.05", "q = 0.95", "sensor.q", "below p"),
    ("prior = 0.5", "prior = 0.97", "belief.threshold", "above prior"),
    (
        "prior = 0.5",
        "prior = 0.5\npeak = 0.4\nexpected = [{ position = [1, 1] }]",
        "belief.peak",
        "must lie from prior",
    ),
    ("[400, 500]", "[400, 5000]", "targets[0].position", "outside the area"),
    ("[400, 700]", "[400, inf]", "targets[1].position[1]", "finite"),
    ("[400, 700]", "[400]", "targets[1].position", "2 numbers"),
    ("[100, 200]", "[100, 105]", "fleet.starts[1]", "apart"),
    ("[100, 200]", "[-60, 200]", "fleet.starts[1]", "fence"),
    ("altitude_min_m = 15", "altitude_min_m = 120", "safety.altitude_max_m", "above"),
    ("altitude_m = 40", "altitude_m = 10", "fleet.altitude_m", "band"),
    ("altitude_m = 40", "altitude_m = 130", "fleet.altitude_m", "band"),
    ("separation_m = 10", "separation_m = 300", "fleet.starts[1]", "apart"),
    ("separation_m = 10", "beacon_range_m = 5", "safety.beacon_range_m", "above separation_m"),
    ('"esustpm"', '"esustmp"', "planner", "did you mean esustpm"),
    ('"esustpm"', "3", "planner", "a string"),
    ('"belief-update"', '"belief"', "belief.merge", "belief-update"),
    ('"multirotor"', '"glider"', "fleet.model", '"multirotor", "perfect"'),
    ('"paced"', '"fast"', "clock", '"paced", "stepped"'),
    ("vehicles = 10", "vehicles = 0", "vehicles", ">= 1"),
    ("vehicles = 10", "vehicles = 251", "vehicles", "<= 250"),
    ("vehicles = 10", "vehicles = true", "vehicles", "whole number"),
    ("vehicles = 10", "vehicles = 200", "vehicles", "fit into the area"),
    ("speed = 10 ", "speed = 0 ", "speed", "> 0"),
    ("speed = 10 ", "speed = inf ", "speed", "<= 1000"),
    ("duration = 900", "duration = -1", "duration", "> 0"),
    ("seed = 1 ", "seed = -1 ", "seed", ">= 0"),
    ("seed = 1 ", f"seed = {10**30} ", "seed", "very large"),
    ("seed = 1 ", "seed = 2024-01-01 ", "seed", "2024-01-01"),
    ('name = "liu2022"', 'name = "Liu 2022"', "name", "must match"),
    ('name = "liu2022"', "", "name", "missing"),
    ("[parameters]", "[parameters]\nguide_gian = 1", "parameters.guide_gian", "guide_gain"),
    ("[parameters]", "[parameters]\nguide_gain = 'x'", "parameters.guide_gain", "a number"),
    ("[parameters]", "[parameters]\nspeed_m_s = -3", "parameters.speed_m_s", "at least"),
    ("[parameters]", "[parameters]\nspeed_m_s = nan", "parameters.speed_m_s", "finite"),
    ("[parameters]", "[[agents]]\nid = 3\n[[agents]]\nid = 3\n", "agents[1].id", "twice"),
    ("[parameters]", "[[agents]]\nid = 0\n", "agents[0].id", ">= 1"),
    ("[parameters]", "[[agents]]\nid = 3\naltitude_m = 5\n", "agents[0].altitude_m", "band"),
    ("[parameters]", "[[agents]]\nid = 3\nstart = [900, 1e5]\n", "agents[0].start", "fence"),
    ("[parameters]", '[bus]\nrouter = "localhost:7447"\n', "bus.router", "endpoint"),
    ("[parameters]", '[bus]\nlisten = "autos"\n', "bus.listen", "endpoint"),
    ("[parameters]", "[simulator]\nports = 80\n", "simulator.ports", '"auto"'),
    ("[parameters]", "[simulator]\nports = 65530\n", "simulator.ports", "no ports"),
    (
        "[parameters]",
        "[simulator.parameters]\nA = 1\nB = '1'\n",
        "simulator.parameters.B",
        "number",
    ),
    (
        "[parameters]",
        "[simulator.parameters]\nmpc = 1\n",
        "simulator.parameters.mpc",
        "no such parameter",
    ),
    (
        "[parameters]",
        "[simulator.parameters]\nCOM_OF_LOS_T = 1\n",
        "simulator.parameters.COM_OF_LOS_T",
        "did you mean COM_OF_LOSS_T?",
    ),
    (
        "[parameters]",
        "[simulator.parameters]\nCOM_ARM_MIS_REQ = 2\n",
        "simulator.parameters.COM_ARM_MIS_REQ",
        "must be 0..1",
    ),
    ("range_m = 400", "keyframe_s = 0", "radio.keyframe_s", "> 0"),
    ("range_m = 400", "frame_bytes = 100", "radio.frame_bytes", ">= 128"),
    ("range_m = 400", "loss = 1.5", "radio.loss", "<= 1"),
    ("range_m = 400", "burst_enter = 0.95", "radio.burst_leave", "at most 1 - burst_enter = 0.05"),
    ("range_m = 400", "burst_enter = 0.1\nburst_leave = 0.0", "radio.burst_leave", "above 0"),
    ("range_m = 400", "bytes_per_s = 0", "radio.bytes_per_s", ">= 1"),
    ("range_m = 400", "[[radio.links]]\nfrom = 77", "radio.links[0].from", "no such agent"),
    ("range_m = 400", "[[radio.links]]\nsender = 1", "radio.links[0].sender", "unknown"),
    ("range_m = 400", "[[radio.links]]\nto = 1\nburst_enter = 1", "radio.links", "burst_leave"),
    ("q = 0.05", "q = 0.05\nperiod_s = 1e308", "sensor.period_s", "<= 86400"),
    ("[400, 700]", "[400, 1e300]", "targets[1].position", "outside"),
    (
        "[parameters]",
        '[[agents]]\nid = 3\nendpoint = "udpin:here"\n',
        "agents[0].endpoint",
        "port must be a number",
    ),
    ("[parameters]", "[wind]\ngust_m_s = -1\n", "wind.gust_m_s", ">= 0"),
]


@pytest.mark.parametrize(("old", "new", "key", "word"), WRONG)
def test_wrong_values(old: str, new: str, key: str, word: str) -> None:
    with pytest.raises(ConfigError) as caught:
        config.parse(edited(old, new), "m.toml")
    message = str(caught.value)
    assert re.match(rf"m\.toml(:\d+)?: {re.escape(key)}: ", message), message
    assert word in message
    assert "\n" not in message
    assert len(message) < 400
    assert caught.value.exit_status == 2


@pytest.mark.parametrize(
    ("old", "new", "line_with"),
    [
        ("range_m = 400", "range_m = -400", "range_m = -400"),
        ("[400, 700]", "[400, 7000]", "[400, 7000]"),
        ("[area] ", "[aera] ", "[aera]"),
        ("speed = 10 ", "speed = 'x' ", "speed = 'x'"),
    ],
)
def test_the_line_is_named(old: str, new: str, line_with: str) -> None:
    text = edited(old, new)
    with pytest.raises(ConfigError) as caught:
        config.parse(text, "m.toml")
    number = int(str(caught.value).split(":")[1])
    assert line_with in text.splitlines()[number - 1]


@pytest.mark.parametrize(
    ("option", "value", "word"),
    [
        ("vehicles", 0, ">= 1"),
        ("vehicles", 200, "fit into the area"),
        ("planner", "nobody", "no such planner"),
        ("clock", "fast", "stepped"),
        ("speed", inf, "<= 1000"),
        ("bus.router", "here", "endpoint"),
    ],
)
def test_a_wrong_option_is_named(option: str, value: object, word: str) -> None:
    with pytest.raises(ConfigError, match=f"^--{option.split('.')[-1]}: .*{word}"):
        config.load(None, {option: value})


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"seed = \n", "not valid TOML: .*line 1"),
        (b"seed = 1\nseed = 2\n", "not valid TOML: .*line 2"),
        (b"name = '\xff'\n", "not UTF-8"),
        (b"x = " + b"[" * 100_000, "nested too deep"),
        (b"x = " + b"9" * 5000, "not valid TOML"),
        (b"#" * 2_000_000, "too large"),
        (b"", "name: is missing"),
    ],
)
def test_files_that_are_no_missions(tmp_path: Path, content: bytes, word: str) -> None:
    path = tmp_path / "m.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=word) as caught:
        config.load(path)
    assert str(caught.value).startswith(str(path))


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such mission file"):
        config.load(tmp_path / "nothing.toml")
    with pytest.raises(ConfigError, match="cannot be read"):
        config.load(tmp_path)
    with pytest.raises(ConfigError, match="cannot be read"):
        config.load("a\0b")


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.dates()
    | st.sampled_from(["auto", "paced", "esustpm", 0.5, 1, 10, [100, 100], [[1, 2]], inf, 10**400]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=6,
)


def paths(schema: dict[str, Any]) -> list[str]:
    """Dotted names of all keys and tables of a mission file, one level deep."""
    names = list(schema["properties"])
    for key, part in schema["properties"].items():
        if "$ref" in part:
            inner = schema["$defs"][part["$ref"].rsplit("/", 1)[-1]]
            names += [f"{key}.{name}" for name in inner["properties"]]
    return names


@given(st.dictionaries(st.sampled_from(paths(json_schema())) | st.text(max_size=6), VALUES))
def test_nothing_but_config_errors(changes: dict[str, object]) -> None:
    mission = config.load()
    try:
        changed = config.override(mission, changes)
    except ConfigError:
        return
    assert np.isfinite(changed.scenario().starts).all()
    assert config.parse(config.to_toml(changed)) == changed


@given(st.text(alphabet="[]{}=.,'\"#\n 0123456789abcdefinstr_-é", max_size=80))
def test_any_text_is_a_mission_or_a_config_error(text: str) -> None:
    with pytest.raises(ConfigError):
        config.parse(text)


def accepts(schema: dict[str, Any], part: dict[str, Any], value: Any) -> bool:
    """A small validator of the schema's own vocabulary."""
    if "$ref" in part:
        part = schema["$defs"][part["$ref"].rsplit("/", 1)[-1]]
    if "anyOf" in part:
        return any(accepts(schema, choice, value) for choice in part["anyOf"])
    if "enum" in part:
        return value in part["enum"]
    kind = {
        "object": dict, "array": list, "string": str, "boolean": bool, "integer": int,
        "number": (int, float),
    }[part["type"]]  # fmt: skip
    if not isinstance(value, kind) or (isinstance(value, bool) and part["type"] != "boolean"):
        return False
    if part["type"] == "object":
        known = part.get("properties", {})
        extra = part.get("additionalProperties", True)
        if set(part.get("required", ())) - set(value):
            return False
        for key, inner in value.items():
            rule = known.get(key, extra)
            if rule is False or (isinstance(rule, dict) and not accepts(schema, rule, inner)):
                return False
    if part["type"] == "array":
        prefix = part.get("prefixItems")
        rules = prefix if prefix is not None else [part["items"]] * len(value)
        if len(rules) != len(value):
            return False
        return all(accepts(schema, rule, inner) for rule, inner in zip(rules, value, strict=True))
    if part["type"] in ("integer", "number"):
        return (
            part.get("minimum", -inf) <= value <= part.get("maximum", inf)
            and part.get("exclusiveMinimum", -inf) < value
            and value < part.get("exclusiveMaximum", inf)
        ) or value == inf
    if "pattern" in part:
        return re.search(part["pattern"], value) is not None
    return True


def test_the_schema_accepts_the_example() -> None:
    schema = json_schema()
    assert accepts(schema, schema, tomllib.loads(EXAMPLE))
    assert accepts(schema, schema, config.load().plain())
    assert not accepts(schema, schema, tomllib.loads(edited("cell_m = 100", "cel_m = 100")))
    assert not accepts(schema, schema, tomllib.loads(edited('"paced"', '"fast"')))
    json.dumps(schema, allow_nan=False)


def test_every_key_is_described() -> None:
    schema = json_schema()
    for part in (schema, *schema["$defs"].values()):
        assert part["description"]
        for key, value in part["properties"].items():
            assert "$ref" in str(value) or value["description"], key
