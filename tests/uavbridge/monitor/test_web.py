"""The page's server without a browser: who is let in, what is told, how a recording plays."""

from __future__ import annotations

import asyncio
import base64
import json

import numpy as np
import pytest

from planners.belief.merge import MERGE_RULES
from planners.grid import Grid
from planners.search.mountain.payload import Told
from planners.search.mountain.payload import encode as payload
from uavbridge.agent.report import AgentReport, encode
from uavbridge.bus import keys
from uavbridge.bus.layers import Layer, encode_layer
from uavbridge.bus.local import LocalHub
from uavbridge.bus.messages import FullMap, encode_map
from uavbridge.bus.wire import DELTA, Frame
from uavbridge.bus.wire import encode as encode_frame
from uavbridge.config import load, to_toml
from uavbridge.errors import ConfigError
from uavbridge.monitor.groups import Membership, membership
from uavbridge.monitor.replayed import Player
from uavbridge.monitor.source import Live
from uavbridge.monitor.web.feed import Feed
from uavbridge.monitor.web.guard import Guard, is_loopback
from uavbridge.monitor.web.server import listen
from uavbridge.recording.recorder import Recorder
from uavbridge.recording.topics import MissionRecord
from uavbridge.recording.topics import encode as encode_record

TOKEN = "a-token-of-some-length"
SECOND = 1_000_000
AT, STILL = (1.0, 2.0, 3.0), (0.0, 0.0, 0.0)
GRID = Grid(0.0, 0.0, 10.0, 4, 3)


def report(agent, t_us, **changes):
    values = {
        "agent": agent,
        "t_us": t_us,
        "phase": "search",
        "mode": "OFFBOARD",
        "position": (10.0 * agent, 5.0, 20.0),
        "velocity": (1.0, 0.0, 0.0),
        "heading": 0.5,
        "armed": True,
        "in_air": True,
        "battery": 0.5,
        "neighbours": 1,
        "note": "",
        "distance_m": 3.0,
        "declared": [],
    }
    return AgentReport(**{**values, **changes})


def frame(agent, t_us, cells=b""):
    return encode_frame(
        Frame(DELTA, agent, 1, t_us, (10.0 * agent, 5.0, 20.0), (1.0, 0.0, 0.0), b"", 1, cells)
    )


def full_map(agent, t_us):
    probability, stamp = np.full(GRID.shape, 0.5), np.full(GRID.shape, -1, np.int64)
    probability[2, 1], stamp[2, 1] = 0.8, 3_000_000
    return encode_map(FullMap(agent, t_us, 0.0, 0.0, 10.0, probability, stamp))


def told(feed):
    """The next messages: JSON ones decoded, binary ones as (owner, {flat: value})."""
    texts, maps = [], []
    for message in feed.next():
        if isinstance(message, str):
            texts.append(json.loads(message))
        else:
            words = np.frombuffer(message, "<u4").tolist()
            assert len(words) == 2 + 2 * words[1]
            maps.append((words[0], dict(zip(words[2::2], words[3::2], strict=True))))
    return texts, maps


async def _ask(app, scope):
    sent = []

    async def receive():
        return {"type": f"{scope['type']}.connect"}

    async def send(message):
        sent.append(message)

    await app(scope, receive, send)
    return sent


async def _inner(scope, receive, send):
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
    else:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"the page"})


def asked(kind="http", *, token=None, query=b"", **headers):
    """What the guard answers: first message sent."""
    headers = {"host": "127.0.0.1:8000", **headers}
    scope = {
        "type": kind,
        "method": "GET",
        "path": "/",
        "query_string": query,
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
    }
    return asyncio.run(_ask(Guard(_inner, token), scope))[0]


@pytest.mark.parametrize("host", ["127.0.0.1:8000", "localhost:1", "[::1]:8000", "127.0.0.1"])
def test_this_machine_needs_no_token(host):
    assert asked(host=host)["status"] == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example:8000", "", "10.0.0.3", "["]
)
def test_other_names_of_this_machine_are_refused(host):
    assert asked(host=host)["status"] == 403


def test_a_foreign_page_opens_no_websocket():
    own = asked("websocket", origin="http://127.0.0.1:8000")
    assert own["type"] == "websocket.accept"
    assert asked("websocket")["type"] == "websocket.accept"  # a program
    for origin in ("http://evil.example", "http://127.0.0.1:8001", "null"):
        assert asked("websocket", origin=origin)["type"] == "websocket.close"


def test_with_a_token_nothing_is_served_without_it():
    for kind, refused in (("http", 401), ("websocket", "websocket.close")):
        for query in (b"", b"token=", b"token=wrong-token-of-length", b"token=%ff"):
            answer = asked(kind, token=TOKEN, query=query, host="10.0.0.3:8000")
            assert refused in (answer.get("status"), answer["type"])
    for headers in ({"cookie": f"uavbridge_token={TOKEN}"}, {"authorization": f"Bearer {TOKEN}"}):
        assert asked(token=TOKEN, host="10.0.0.3:8000", **headers)["status"] == 200
        assert asked("websocket", token=TOKEN, **headers)["type"] == "websocket.accept"


def test_the_token_leaves_the_address_for_a_cookie():
    answer = asked(token=TOKEN, query=f"token={TOKEN}".encode())
    headers = dict(answer["headers"])
    assert answer["status"] == 303
    assert headers[b"location"] == b"/"
    assert b"HttpOnly" in headers[b"set-cookie"]
    assert b"SameSite=strict" in headers[b"set-cookie"]


def test_every_answer_bears_the_policy():
    for answer in (asked(), asked(host="evil.example"), asked(token=TOKEN)):
        policy = dict(answer["headers"])[b"content-security-policy"].decode()
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy


@pytest.mark.parametrize(
    ("host", "token"), [("0.0.0.0", None), ("::", None), ("127.0.0.1", "short")]
)
def test_others_are_served_only_with_a_token_worth_the_name(host, token):
    with pytest.raises(ConfigError, match="--token"):
        listen(host, 0, token)
    assert is_loopback("127.8.9.10")


def test_a_page_is_told_everything_once_and_then_what_changed():
    bus = LocalHub().bus()
    source = Live(bus, "demo")
    bus.publish(keys.state(1), encode(report(1, 5_000_000, note="<b>up</b>")))
    bus.publish(keys.state_map(1), full_map(1, 5_000_000))
    source.step()
    feed = Feed(source)
    texts, maps = told(feed)
    assert [text["kind"] for text in texts] == ["mission", "update"]
    assert texts[0]["grid"] == [0.0, 0.0, 10.0, 4, 3]
    assert texts[0]["targets"] is None  # nobody told
    assert texts[1]["vehicles"] == [[1, 10.0, 5.0, 20.0, 1.0, 0.0, 0.5]]
    assert texts[1]["rows"][0]["note"] == "<b>up</b>"
    assert [owner for owner, _ in maps] == [0]
    assert maps[0][1][2 * 3 + 1] == 204 | 4 << 8  # 0.8, seen in the fourth second
    assert maps[0][1][0] == 128  # 0.5, never seen

    texts, maps = told(feed)
    assert not maps
    assert not {"rows", "events", "points", "declared"} & texts[0].keys()

    record = np.zeros(1, MERGE_RULES["belief-update"].record)
    record["cell"], record["origin"], record["probability"] = 5, 1, 0.25
    record["stamp_us"] = 6_000_000
    bus.publish(keys.air((0, 0), 1), frame(1, 6_000_000, record.tobytes()))
    source.step()
    assert told(feed)[1] == [(0, {5: 64 | 7 << 8})]
    feed.look(1)
    assert [owner for owner, _ in told(feed)[1]] == [1]


def test_a_page_is_told_anew_when_the_mission_becomes_known():
    bus = LocalHub().bus()
    source = Live(bus, "liu2022")
    feed = Feed(source)
    assert told(feed)[0][0]["grid"] is None
    mission = load(None, {"vehicles": 3})
    bus.publish(keys.MISSION, encode_record(MissionRecord(to_toml(mission), 1, "paced")))
    source.step()
    texts, maps = told(feed)
    assert texts[0]["kind"] == "mission"
    assert [tuple(t) for t in texts[0]["targets"]] == [t.position for t in mission.targets]
    assert len(maps[0][1]) == mission.grid.size


def test_links_are_as_the_radio_range_allows():
    bus = LocalHub().bus()
    source = Live(bus, "liu2022")
    mission = load(None, {"vehicles": 3, "radio.range_m": 12.0})
    bus.publish(keys.MISSION, encode_record(MissionRecord(to_toml(mission), 1, "paced")))
    for agent in (1, 2, 3):
        bus.publish(keys.air((0, 0), agent), frame(agent, 1_000_000))
    source.step()
    feed = Feed(source)
    feed.look(3)
    update = told(feed)[0][1]
    assert update["links"] == [[1, 2], [2, 3]]
    assert update["hears"] == [2]


def test_a_mission_that_is_started_anew_is_another_one():
    bus = LocalHub().bus()
    source = Live(bus, "demo")
    bus.publish(keys.state(1), encode(report(1, 500_000_000, phase="landed")))
    source.step()
    feed = Feed(source)
    assert told(feed)[0][0]["kind"] == "mission"
    for second in range(30):
        bus.publish(keys.state(1), encode(report(1, second * 1_000_000)))
    source.step()
    bus.publish(keys.state(1), encode(report(1, 30_000_000)))
    source.step()
    texts, _ = told(feed)
    assert texts[0]["kind"] == "mission"
    assert texts[1]["t_s"] == 30.0


def test_malformed_samples_change_nothing():
    bus = LocalHub().bus()
    source = Live(bus, "demo")
    noise = b'{"agent": 1}', b"UB\x01\x04" + bytes(60), b"\xff" * 80, b"[" * 100_000
    for key in ("state/1", "state/1/map", "state/1/event", "state/x", "air/0/0/1", "safety/0/0/1"):
        for data in noise:
            bus.publish(key, data)
    for key in ("world/truth", "world/mission", "world/past", "cmd/all", "cmd/1", "state/1/ack"):
        for data in noise:
            bus.publish(key, data)
    # one's report under another's name, and a clock of the next century
    bus.publish(keys.state(2), encode(report(1, 1_000_000)))
    bus.publish(keys.state(1), encode(report(1, 1_000_000)))
    bus.publish(keys.state(3), encode(report(3, 10**15)))
    source.step()
    assert source.watch.t_us == 1_000_000
    assert [agent for agent, one in source.watch.agents.items() if one.report] == [1]
    assert sum(source.watch.rejects.values()) > 10


@pytest.fixture
def recording(tmp_path):
    """Two agents fly east for a minute; the first sees a cell every ten seconds."""
    mission = load(None, {"vehicles": 2})
    with Recorder(tmp_path, mission_name="demo", epoch_ns=10**18) as recorder:
        recorder.record("mission", 0, MissionRecord(to_toml(mission), 1, "stepped"))
        for second in range(61):
            t_us = second * 1_000_000
            for agent in (1, 2):
                said = report(agent, t_us, position=(5.0 * second, 10.0 * agent, 20.0))
                recorder.write(f"state/{agent}", t_us, encode(said))
            record = np.zeros(int(second % 10 == 0), MERGE_RULES["belief-update"].record)
            record["cell"], record["stamp_us"] = second // 10, t_us
            recorder.write("air/1", t_us, frame(1, t_us, record.tobytes()))
    return tmp_path


def at(player, t_s):
    """The player's picture at a moment."""
    player.playing = False
    player.seek(int(t_s * 1e6))
    while True:
        player.step()
        if not player.seeking:
            return player.watch


@pytest.mark.parametrize("way", [(30,), (60, 30), (55, 2, 30), (60, 45, 10, 30)])
def test_a_moment_of_a_recording_is_the_same_whichever_way_one_came(recording, way):
    player = Player(recording)
    for t_s in way:
        watch = at(player, t_s)
    assert watch.t_us == 30_000_000
    assert watch.agents[2].position == (150.0, 20.0, 20.0)
    assert [point.t_us for point in watch.series] == [s * 1_000_000 for s in range(31)]
    assert len(watch.agents[1].track) == 30
    _, seen = watch.merged()
    assert np.flatnonzero(seen).tolist() == [0, 1, 2, 3]
    assert player.end_us == 60_000_000


def test_a_recording_stops_at_its_end_and_begins_anew(recording):
    player = Player(recording)
    at(player, 60)
    player.play(True)
    assert player.playing
    player.step()
    assert player.watch.t_us < 1_000_000


def test_a_page_is_told_the_terrain_and_the_layer_it_asks_for():
    bus = LocalHub().bus()
    source = Live(bus, "demo")
    ground = {"terrain.steepest_deg": 20.0}
    mission = load(None, {"vehicles": 1, **ground})
    bus.publish(keys.MISSION, encode_record(MissionRecord(to_toml(mission), 1, "paced")))
    values = np.arange(12.0).reshape(4, 3)
    bus.publish(keys.layer("path", 2), encode_layer(Layer(SECOND, 0.0, 0.0, 10.0, values)))
    for name in ("layer/Path", "layer/a/b", "layer/" + "x" * 50):
        bus.publish(name, encode_layer(Layer(SECOND, 0.0, 0.0, 10.0, values)))
    bus.publish(keys.layer("path", 2), encode_layer(Layer(0, 0.0, 0.0, 10.0, -values)))  # late
    source.step()
    feed = Feed(source)
    texts, _ = told(feed)
    terrain = next(text for text in texts if text["kind"] == "ground")
    assert terrain["name"] == "terrain"
    heights = mission.terrain().heights
    assert (terrain["low"], terrain["high"]) == (heights.min(), heights.max())
    columns, rows = terrain["grid"][3:]
    assert len(base64.b64decode(terrain["shade"])) == columns * rows
    assert texts[-1]["layers"] == ["path/2"]
    feed.show("path/2")
    (_, layer), _ = told(feed)
    shown = np.frombuffer(base64.b64decode(layer["values"]), np.uint8).reshape(4, 3)
    np.testing.assert_allclose(shown / 255 * 11, values, atol=0.03)
    assert layer["grid"] == [0.0, 0.0, 10.0, 4, 3]
    assert len(told(feed)[0]) == 1  # once, until it changes
    feed.show("unknown")
    assert len(told(feed)[0]) == 1


def test_a_page_is_told_who_leads_whom():
    bus = LocalHub().bus()
    source = Live(bus, "demo")
    mission = to_toml(load(None, {"vehicles": 3})).replace('"esustpm"', '"mountain"')
    bus.publish(keys.MISSION, encode_record(MissionRecord(mission, 1, "paced")))
    for agent, said in ((1, Told(task=5, leads=True)), (2, Told(task=5)), (3, Told())):
        data = encode_frame(
            Frame(
                DELTA, agent, 1, SECOND, (1.0, 2.0, 3.0), (0.0, 0.0, 0.0), payload(said, 1), 1, b""
            )
        )
        bus.publish(keys.air((0, 0), agent), data)
    source.step()
    texts, _ = told(Feed(source))
    assert texts[-1]["groups"] == [[1, 5, True], [2, 5, False]]


def test_planners_without_a_payload_of_groups_say_so_in_words():
    assert membership("pheromone-scenario", 1, b"", "leads to 4,5") == Membership(1, True)
    assert membership("pheromone-scenario", 2, b"x", "follows 1") == Membership(1, False)
    assert membership("pheromone-scenario", 3, b"", "misleads") is None
    assert membership("mountain", 3, b"", "leads") is None
