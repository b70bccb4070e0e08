"""What Foxglove is given: its own schemas read it, and it says what was flown."""

import base64
import importlib

import msgspec
import numpy as np
import pytest
from google.protobuf.json_format import ParseDict
from mcap.reader import make_reader

from uavbridge.agent.report import AgentReport
from uavbridge.config import load
from uavbridge.recording.display import Display
from uavbridge.recording.recorder import MCAP_NAME, Recorder
from uavbridge.recording.topics import TOPICS
from uavbridge.report.result import Event

EPOCH_NS = 1_700_000_000_000_000_000
SECONDS = 4


def report(agent, t_us, phase="search"):
    return AgentReport(
        agent=agent, t_us=t_us, phase=phase, mode="OFFBOARD",
        position=(100.0 * agent, t_us / 1e6, 40.0), velocity=(0.0, 1.0, 0.0), heading=np.pi / 2,
        armed=True, in_air=True, battery=0.5, neighbours=1, note="", distance_m=0.0, declared=[],
    )  # fmt: skip


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """A made-up mission, displayed: {topic: [(schema name, document)]}, and its folder."""
    folder = tmp_path_factory.mktemp("shown")
    mission = load(None, {"radio.range_m": 150.0})
    with Recorder(folder, mission_name="m", epoch_ns=EPOCH_NS) as recorder:
        display = Display(recorder, mission)
        for t_us in range(0, SECONDS * 1_000_000, 1_000_000):
            seen = np.zeros((10, 10), bool)
            seen[2, 7] = True
            belief = np.where(seen, 0.9, 0.5)
            reports = [report(1, t_us), report(2, t_us), report(9, t_us, phase="connect")]
            declared = [(2, 7)] if t_us >= 2_000_000 else []
            display.second(t_us, reports, (belief, seen), declared)
            display.log([Event(t_us / 1e6, "low battery", 2, "failure")])
    found = {}
    with (folder / MCAP_NAME).open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
            document = msgspec.json.decode(message.data)
            assert message.log_time >= EPOCH_NS
            found.setdefault(channel.topic, []).append((schema.name, document))
    return found


def official(name):
    """A message of Foxglove's own schema."""
    short = name.removeprefix("foxglove.")
    return getattr(importlib.import_module(f"foxglove_schemas_protobuf.{short}_pb2"), short)()


def as_protobuf(value):
    """JSON as Foxglove has it, to JSON as protobuf has it: dates and durations are texts there."""
    if isinstance(value, list):
        return [as_protobuf(part) for part in value]
    if not isinstance(value, dict):
        return value
    if value.keys() == {"sec", "nsec"}:
        date = np.datetime64(value["sec"] * 10**9 + value["nsec"], "ns")
        return f"{date}Z" if value["sec"] else "0s"
    return {name: as_protobuf(part) for name, part in value.items()}


def test_every_message_is_one_of_foxgloves(shown):
    assert {topic.partition("/")[0] for topic in shown} == {
        name for name, topic in TOPICS.items() if topic.package == "foxglove"
    }
    for messages in shown.values():
        for name, document in messages:
            parsed = ParseDict(as_protobuf(document), official(name))  # raises for unknown fields
            assert parsed.ByteSize() > 0


@pytest.mark.parametrize("name", [n for n, t in TOPICS.items() if t.package == "foxglove"])
def test_schemas_have_the_official_fields(name):
    full, _, data = TOPICS[name].schema()
    fields = {field.name: field for field in official(full).DESCRIPTOR.fields}
    ours = msgspec.json.decode(data)["properties"]
    assert ours.keys() <= fields.keys()
    for field, part in ours.items():
        assert (part["type"] == "array") == fields[field].is_repeated
    assert b"$ref" not in data


def test_poses_and_places_are_where_the_agents_are(shown):
    assert shown.keys() >= {"pose/1", "pose/2", "fix/1"}
    assert "pose/9" not in shown  # it does not know yet where it is
    _, last = shown["pose/2"][-1]
    assert last["pose"]["position"] == {"x": 200.0, "y": SECONDS - 1.0, "z": 40.0}
    assert last["pose"]["orientation"]["z"] == pytest.approx(np.sin(np.pi / 4))
    assert last["timestamp"] == {"sec": EPOCH_NS // 10**9 + SECONDS - 1, "nsec": 0}
    home = load(None, {}).home
    _, fix = shown["fix/1"][0]
    east = 100.0 / (111_320.0 * np.cos(np.radians(home.latitude_deg)))
    assert fix["longitude"] - home.longitude_deg == pytest.approx(east, rel=0.01)
    assert fix["altitude"] == pytest.approx(home.altitude_m + 40.0, abs=0.1)


def test_the_grid_is_the_merged_map(shown):
    _, grid = shown["grid"][-1]
    cells = np.frombuffer(base64.b64decode(grid["data"]), [("p", "<f4"), ("seen", "u1")])
    cells = cells.reshape(-1, grid["column_count"])  # rows from the south, columns from the west
    assert grid["row_stride"] == grid["column_count"] * grid["cell_stride"]
    assert np.argwhere(cells["seen"]).tolist() == [[7, 2]]
    assert cells["p"][7, 2] == pytest.approx(0.9)


def test_the_scene_has_vehicles_links_targets_and_what_was_declared(shown):
    _, scene = shown["scene"][-1]
    entities = {entity["id"]: entity for entity in scene["entities"]}
    assert [text["text"] for text in entities["vehicles"]["texts"]] == ["1 search", "2 search"]
    assert entities["links"]["lines"][0]["indices"] == [0, 1]
    assert len(shown["area"]) == 2  # at first, and when a target was declared
    _, area = shown["area"][-1]
    assert len(area["entities"][0]["spheres"]) == len(load(None, {}).targets)
    (cube,) = area["entities"][0]["cubes"]
    assert (cube["pose"]["position"]["x"], cube["pose"]["position"]["y"]) == (250.0, 750.0)


def test_each_event_is_logged_once(shown):
    assert [document["level"] for _, document in shown["log"]] == [4] * SECONDS
    assert shown["log"][0][1]["name"] == "agent 2"
