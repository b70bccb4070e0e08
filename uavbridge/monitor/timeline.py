"""A recording's time line in the terminal: where it stands, and the keys that move it."""

from __future__ import annotations

from rich.text import Text

from uavbridge.clock import to_s, to_us
from uavbridge.monitor.replayed import Player
from uavbridge.report.quantity import duration

HELP = "space play  ←→ 10 s  pgup pgdn 1 min  home end  +- speed  ↑↓ agent  q quit"
SPEEDS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
STEPS_S = {"left": -10.0, "right": 10.0, "pgup": -60.0, "pgdn": 60.0}
_BAR_LEAST = 5


def turn(player: Player, key: str) -> None:
    """What one key does to a recording, if anything."""
    if key == " ":
        player.play(not player.playing)
    elif key in STEPS_S:
        player.seek(player.target_us + to_us(STEPS_S[key]))
    elif key in ("home", "end"):
        player.seek(0 if key == "home" else player.end_us)
    elif key in ("+", "="):
        player.speed = next((s for s in SPEEDS if s > player.speed), SPEEDS[-1])
    elif key in ("-", "_"):
        player.speed = next((s for s in reversed(SPEEDS) if s < player.speed), SPEEDS[0])


def line(player: Player, width: int) -> Text:
    """The time line."""
    state = "seeking" if player.seeking else "playing" if player.playing else "paused"
    now_us = min(max(player.watch.t_us, 0), player.end_us)
    left = f"{state:<7} {player.speed:g}x  {duration(to_s(now_us))} "
    right = f" {duration(to_s(player.end_us))}"
    room = max(width - len(left) - len(right), _BAR_LEAST)
    at = round((room - 1) * now_us / max(player.end_us, 1))
    return Text.assemble(
        (left, "bold"), ("━" * at, "cyan"), "●", ("─" * (room - 1 - at), "dim"), right
    )
