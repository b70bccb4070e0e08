"""Who may do what on the bus, as rules and as zenoh's log tells it."""

from hypothesis import given
from hypothesis import strategies as st

from uavbridge.bus import keys
from uavbridge.bus.matching import intersects
from uavbridge.bus.refusals import Refusal, RefusalLog
from uavbridge.bus.security import Access, access_control

ACL = access_control(Access("swarm", [1, 2, 3], [1001, 1002]))
WRITING, HEARING = "put", "declare_subscriber"


def may(who, message, key):
    """Whether the router would take it."""
    rules = {rule["id"]: rule for rule in ACL["rules"]}
    policy = next(policy for policy in ACL["policies"] if policy["subjects"] == [who])
    return any(
        message in rules[name]["messages"]
        and "ingress" in rules[name]["flows"]
        and any(intersects(pattern, key) for pattern in rules[name]["key_exprs"])
        for name in policy["rules"]
    )


@given(st.integers(1, 3), st.integers(1, 3), st.integers(-5, 5), st.integers(-5, 5))
def test_an_agent_writes_its_own_keys_alone(agent, other, x, y):
    for key in (
        keys.air((x, y), other),
        keys.safety((x, y), other),
        keys.state(other),
        keys.ack(other),
        keys.alive(other),
    ):
        assert may(f"agent-{agent}", WRITING, f"uavbridge/swarm/{key}") == (agent == other)


def test_commands_come_from_operators_and_the_launcher():
    for who, allowed in (
        ("operator", True),
        ("launcher", True),
        ("monitor", False),
        ("agent-1", False),
    ):
        assert may(who, WRITING, "uavbridge/swarm/cmd/all") is allowed
        assert may(who, WRITING, "uavbridge/swarm/cmd/1") is allowed


def test_agents_hear_neither_the_targets_nor_orders_and_readings_of_others():
    assert may("agent-1", HEARING, "uavbridge/swarm/obs/1")
    assert may("agent-1", HEARING, "uavbridge/swarm/air/0/0/2")
    for key in ("world/mission", "obs/2", "cmd/2", "state/2/map"):
        assert not may("agent-1", HEARING, f"uavbridge/swarm/{key}")


def test_a_place_agent_answers_for_itself_and_tells_its_neighbours():
    for key, allowed in (
        ("place/air/0/0/1001", True),
        ("place/air/0/0/1002", False),
        ("place/air/0/0/1", False),
        ("place/net/1002", True),
        ("layer/pheromone-path", True),
        ("layer/grey/1", False),
        ("air/0/0/1001", False),
        ("cmd/1", False),
        ("state/1", False),
    ):
        assert may("place-1001", WRITING, f"uavbridge/swarm/{key}") is allowed
    for key, allowed in (
        ("place/air/0/0/1", True),
        ("state/1", True),
        ("world/truth", True),
        ("world/mission", False),
        ("cmd/all", False),
        ("obs/1", False),
    ):
        assert may("place-1001", HEARING, f"uavbridge/swarm/{key}") is allowed


def test_nobody_writes_into_another_mission():
    for who in ("agent-1", "operator", "monitor", "launcher"):
        assert not may(who, WRITING, "uavbridge/other/cmd/all")
    assert ACL["default_permission"] == "deny"


def _acl(what, *, cached=False):
    subject = "" if cached else " on Interface(lo)+CertCommonName(monitor)+Transport(Tls)+ab12"
    before = "Using cached result: " if cached else ""
    return (
        "2026-01-01T00:00:00Z TRACE rx-0 ThreadId(09) zenoh::net::routing::interceptor"
        f"::access_control: {before}ab12{subject} is unauthorized to {what} (ingress) on k/cmd"
    )


def test_looks_ahead_are_no_refusals():
    log = RefusalLog()
    log.feed("... ThreadId(09) x::access_control: ACL (ingress): caching permissions for `k/cmd` .")
    for what in ("Query", "Reply", "Put", "Delete", "A", "B", "C", "D", "E"):
        assert log.feed(_acl(what)) is None
    assert log.feed(_acl("Put", cached=True)) == Refusal("monitor", "Put", "k/cmd")
    assert log.feed(_acl("Put")) == Refusal("monitor", "Put", "k/cmd")
    assert log.counts.total() == 2


def test_refused_sessions_are_counted_by_reason():
    log = RefusalLog()
    said = "invalid peer certificate: certificate expired: verification time 1 (UNIX), but"
    line = f"\x1b[33m WARN \x1b[0m acc-0 ThreadId(05) zenoh_link_tls::unicast: {said} 2. Hint: x"
    assert log.feed(line) == Refusal("", "invalid peer certificate: certificate expired", "")
    assert log.feed("anything else") is None
