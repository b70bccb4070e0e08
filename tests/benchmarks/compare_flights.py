"""Fly the ground station's side of a recorded flight with a simulated vehicle, and compare.

    python tests/benchmarks/compare_flights.py FOLDER NAME KIND AUTOPILOT

FOLDER has NAME.tlog (both ways) and NAME-steps.csv (time_s, phase, north_m, east_m, down_m).
KIND: multirotor, rover, plane. Prints a row a phase: how far apart the two vehicles were, on
average and at most, how far the recorded one went; and the acknowledgements that differ.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import Any

import numpy as np
from pymavlink import mavutil

from sim_vehicles.codec import Counts, decode
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic

STATION = 255


def recorded(path: Path) -> list[tuple[float, Any]]:
    """Messages of a tlog and seconds since its first."""
    log = mavutil.mavlink_connection(str(path), dialect="ardupilotmega")
    messages = []
    while (message := log.recv_msg()) is not None:
        messages.append((message._timestamp, message))
    start = messages[0][0]
    return [(time - start, message) for time, message in messages]


def replay(
    flight: list[tuple[float, Any]], kind: str, autopilot: str
) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Time, north, east, down of the simulated vehicle, and what it acknowledged."""
    theirs = [message for _, message in flight if message.get_srcSystem() != STATION]
    home = next(
        each for each in theirs if each.get_type() == "GLOBAL_POSITION_INT" and abs(each.lat) > 1e8
    )
    spec = VehicleSpec(theirs[0].get_srcSystem(), (0.0, 0.0, 0.0), kind=kind, autopilot=autopilot)
    place = Geodetic(home.lat / 1e7, home.lon / 1e7, (home.alt - home.relative_alt) / 1e3)
    fleet = Fleet([spec], origin=place)
    track, acks = [], []
    for time, message in flight:
        fleet.advance(round(time * 1e6))
        if message.get_srcSystem() == STATION:
            fleet.receive(0, bytes(message.get_msgbuf()))
        x, y, z = fleet.states.position[0].tolist()
        track.append((time, y, x, -z))
        for _, datagram in fleet.transmit():
            for packet in decode(datagram, Counts()):
                if packet.message.msgname == "COMMAND_ACK":
                    acks.append((packet.message.command, packet.message.result))
    return np.array(track), acks


def main() -> None:
    folder, name, kind, autopilot = Path(sys.argv[1]), *sys.argv[2:5]
    flight = recorded(folder / f"{name}.tlog")
    track, acks = replay(flight, kind, autopilot)
    boot = next(
        (time, message.time_boot_ms / 1e3)
        for time, message in flight
        if message.get_type() == "LOCAL_POSITION_NED"
    )
    offset = boot[1] - boot[0]
    rows: dict[str, list[list[float]]] = {}
    with (folder / f"{name}-steps.csv").open() as file:
        for row in csv.DictReader(file):
            place = [float(row[key]) for key in ("time_s", "north_m", "east_m", "down_m")]
            rows.setdefault(row["phase"], []).append(place)
    print("| phase | length s | way m | apart: mean m | most m |\n| --- | --- | --- | --- | --- |")
    for phase, places in rows.items():
        at = np.array(places)
        ours = [np.interp(at[:, 0] - offset, track[:, 0], track[:, i]) for i in (1, 2, 3)]
        apart = np.linalg.norm(at[:, 1:] - np.stack(ours, axis=-1), axis=1)
        way = np.linalg.norm(np.diff(at[:, 1:], axis=0), axis=1).sum()
        length = at[-1, 0] - at[0, 0]
        print(f"| {phase} | {length:.0f} | {way:.0f} | {apart.mean():.1f} | {apart.max():.1f} |")
    real = [
        (message.command, message.result)
        for _, message in flight
        if message.get_type() == "COMMAND_ACK" and message.get_srcSystem() != STATION
    ]
    print(f"acknowledged: {len(real)} recorded, {len(acks)} here")
    print("recorded only:", [each for each in real if each not in acks])
    print("here only:", [each for each in acks if each not in real])


if __name__ == "__main__":
    main()
