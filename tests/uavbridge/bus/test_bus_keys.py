import pytest
import zenoh

from uavbridge.bus import keys

ALL = {
    keys.air((-1, 2), 7): 7,
    keys.safety((0, 0), 3): 3,
    keys.obs(1): 1,
    keys.place((3, -1), 1002): 1002,
    keys.place_net(1001): 1001,
    keys.cmd(4): 4,
    keys.cmd(): None,
    keys.state(5): 5,
    keys.state_map(5): 5,
    keys.state_cells(5): 5,
    keys.layer("path"): None,
    keys.layer("path", 8): 8,
    keys.TRUTH: None,
    keys.alive(6): 6,
    keys.pace(9): 9,
}


@pytest.mark.parametrize(("key", "agent"), ALL.items())
def test_every_key_is_in_the_table_and_names_its_agent(key: str, agent: int | None) -> None:
    assert keys.space_of(key) is not None
    assert keys.agent_of(key) == agent
    zenoh.KeyExpr(keys.prefix("m") + key)


def test_the_table_has_no_other_spaces() -> None:
    assert {key.partition("/")[0] for key in ALL} == set(keys.SPACES)
    assert keys.space_of("nowhere/1") is None


@pytest.mark.parametrize("mission", ["liu2022", "Liu 2022 #1", "a/b", "@x", "*", "Überflug?", "$*"])
def test_any_name_makes_a_key(mission: str) -> None:
    prefix = keys.prefix(mission)
    assert prefix.count("/") == 2
    zenoh.KeyExpr(prefix + "air/0/0/1")


def test_a_mission_needs_a_name() -> None:
    with pytest.raises(ValueError, match="name"):
        keys.prefix("")
