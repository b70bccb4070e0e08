"""Command line of the simulator alone."""

from __future__ import annotations

import asyncio
import json
import logging
import signal
from dataclasses import dataclass
from math import ceil, inf, isinf, isnan, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from sim_vehicles import ports
from sim_vehicles.dynamics import MODELS, WindSpec
from sim_vehicles.geodesy import Geodetic

if TYPE_CHECKING:
    from collections.abc import Callable

    from sim_vehicles.codec.signing import Keyring
    from sim_vehicles.fleet import Fleet
    from sim_vehicles.server import Report
    from sim_vehicles.transport import Transport

# name on the command line -> kind of vehicle
KINDS: Final = {"copter": "multirotor", "plane": "plane", "rover": "rover"}
AUTOPILOTS: Final = ("px4", "ardupilot")
_MODELS: Final = (*MODELS, "six-dof", "guidance")  # the last two are planes'
_ROWS: Final = 20  # a longer table is drawn together
_HOME: Final = "47.397742,8.545594,488"  # where PX4's simulations start


class Amount(click.FloatRange):
    """A number from 0 on, not infinite unless said so, and never NaN."""

    def __init__(self, *, min_open: bool = False, infinite: bool = False) -> None:
        super().__init__(min=0, min_open=min_open)
        self._infinite = infinite

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        number = float(super().convert(value, param, ctx))
        if isnan(number) or (isinf(number) and not self._infinite):
            self.fail(f"{value} is not a number to work with", param, ctx)
        return number


def _three(_: click.Context, param: click.Parameter, text: str) -> tuple[float, float, float]:
    """Three numbers with commas between."""
    try:
        first, second, third = (float(part) for part in text.split(","))
    except ValueError:
        raise click.BadParameter(f"{text!r} is not {param.metavar}") from None
    return first, second, third


def _place(context: click.Context, param: click.Parameter, text: str) -> Geodetic:
    """A geodetic position: degrees and metres."""
    try:
        return Geodetic(*_three(context, param, text))
    except ValueError as error:
        raise click.BadParameter(str(error)) from None


def _address(_: click.Context, param: click.Parameter, text: str | None) -> tuple[str, int] | None:
    """A host and a port; the host may be left out."""
    if text is None:
        return None
    host, _colon, port = text.rpartition(":")
    if not (port.isascii() and port.isdigit() and 1 <= int(port) <= 65535):
        raise click.BadParameter(f"{text!r} is not {param.metavar}")
    return host or "127.0.0.1", int(port)


def _parameters(
    _: click.Context, param: click.Parameter, texts: tuple[str, ...]
) -> dict[str, float]:
    """Names and values."""
    values: dict[str, float] = {}
    for text in texts:
        name, _equals, value = text.partition("=")
        try:
            values[name] = float(value)
        except ValueError:
            raise click.BadParameter(f"{text!r} is not {param.metavar}") from None
    return values


def _keys(_: click.Context, __: click.Parameter, path: str | None) -> Keyring | None:
    """The keys of a file."""
    if path is None:
        return None
    from sim_vehicles.codec.signing import read_keys

    try:
        return read_keys(Path(path))
    except ValueError as error:
        raise click.BadParameter(str(error)) from None


@dataclass(frozen=True, slots=True)
class Options:
    """What the command line asks for."""

    count: int
    ports: str | None
    port: int | None
    tcp: bool
    host: str
    start_system: int | None
    speed: float
    duration: float
    in_air: float | None
    model: str
    kind: str
    autopilot: str
    seed: int
    wind: tuple[float, float, float]
    gust: float
    home: Geodetic
    spacing: float
    endurance: float
    params: dict[str, float]
    gcs: tuple[str, int] | None
    as_json: bool
    signing_keys: Keyring | None


@click.command(context_settings={"help_option_names": ["-h", "--help"], "show_default": True})
@click.option("--count", default=1, type=click.IntRange(1, 5000), help="Number of vehicles.")
@click.option(
    "--ports",
    type=click.Choice(["each", "shared"]),
    help="A port for each vehicle, or one for all (250 a port).  [default: each up to 10 vehicles]",
)
@click.option(
    "--port",
    type=click.IntRange(1, 65535),
    help="First port.  [default: 14540, or the next that no other simulator here has]",
)
@click.option("--tcp", is_flag=True, help="Listen for TCP clients on the ports instead of UDP.")
@click.option("--host", default="127.0.0.1", help="Where UDP goes to, or TCP listens.")
@click.option(
    "--start-system",
    type=click.IntRange(1, ports.NETWORK),
    help="System id of the first vehicle.  [default: 1, or the next that no other simulator has]",
)
@click.option(
    "--speed",
    default=1.0,
    type=Amount(min_open=True, infinite=True),
    help="Simulated seconds per second; inf: as fast as it can.",
)
@click.option(
    "--duration",
    default=inf,
    type=Amount(min_open=True, infinite=True),
    show_default="until Ctrl-C",
    help="Simulated seconds to run for.",
)
@click.option(
    "--in-air",
    is_flag=False,
    flag_value=20.0,
    type=Amount(min_open=True),
    metavar="[HEIGHT]",
    help="Start flying, at 20 m or HEIGHT metres.",
)
@click.option("--model", default="multirotor", type=click.Choice(_MODELS), help="Dynamics.")
@click.option("--kind", default="copter", type=click.Choice(list(KINDS)), help="Kind of vehicle.")
@click.option(
    "--autopilot", default="px4", type=click.Choice(AUTOPILOTS), help="Which it speaks as."
)
@click.option("--seed", default=0, type=click.IntRange(min=0), help="Seed of gusts and noise.")
@click.option("--wind", default="0,0,0", metavar="E,N,U", callback=_three, help="Mean wind, m/s.")
@click.option("--gust", default=0.0, type=Amount(), help="Gusts, m/s (1 sigma).")
@click.option(
    "--home", default=_HOME, metavar="LAT,LON,ALT", callback=_place, help="Origin, degrees and m."
)
@click.option("--spacing", default=10.0, type=Amount(), help="Metres between starts.")
@click.option(
    "--endurance",
    default=1.0,
    type=Amount(min_open=True),
    help="Capacity of the batteries, times that of the model; a copter's lasts 20 minutes.",
)
@click.option(
    "--param",
    "params",
    multiple=True,
    metavar="NAME=VALUE",
    callback=_parameters,
    help="Parameter of the autopilots, other than its default; may be repeated.",
)
@click.option(
    "--gcs",
    metavar="HOST:PORT",
    callback=_address,
    help="Send all vehicles there too: a ground station listens, 127.0.0.1:14550 by habit.",
)
@click.option(
    "--signing-keys",
    metavar="FILE",
    callback=_keys,
    help="Sign with the keys in FILE (MAVLink 2), and take nothing that is not.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the table and the end as JSON lines.")
@click.version_option(package_name="uavbridge")
def main(**values: Any) -> None:
    """Serve simulated vehicles to any MAVLink client, until Ctrl-C.

    Each vehicle is a MAVLink 2 system that streams telemetry unasked and takes commands,
    parameters, missions and setpoints.
    """
    options = Options(**values)
    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    try:
        seats = _seats(options)
        fleet = _fleet(options, seats)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    except ports.ServerError as error:
        raise click.ClickException(str(error)) from error
    try:
        transport = _transport(options, seats)
    except ports.ServerError as error:
        raise click.ClickException(str(error)) from error
    report = asyncio.run(_fly(options, seats, fleet, transport))
    _sum_up(options, fleet, report)


def _seats(options: Options) -> tuple[ports.Seat, ...]:
    """As asked for; where nothing is, what no other simulator of this machine has."""
    from sim_vehicles.leases import Leases, lease_seats

    each = None if options.ports is None else options.ports == "each"
    return lease_seats(
        options.count,
        Leases(),  # held until this process ends
        each=each,
        port=options.port,
        start_system=options.start_system,
    )


def _fleet(options: Options, seats: tuple[ports.Seat, ...]) -> Fleet:
    """The vehicles in rows and columns, the first one at home, all facing north."""
    from sim_vehicles.fleet import Fleet, VehicleSpec

    columns = ceil(sqrt(options.count))
    specs = [
        VehicleSpec(
            system=seat.system,
            start=(i % columns * options.spacing, i // columns * options.spacing, 0.0),
            yaw_rad=pi / 2,
            kind=KINDS[options.kind],
            in_air_m=options.in_air,
            autopilot=options.autopilot,
        )
        for i, seat in enumerate(seats)
    ]
    wind = WindSpec(mean_m_s=options.wind, gust_m_s=options.gust, gust_up_m_s=options.gust / 3)
    return Fleet(
        specs,
        origin=options.home,
        model=options.model,
        seed=options.seed,
        wind=wind,
        parameters=options.params,
        endurance=options.endurance,
    )


def _transport(options: Options, seats: tuple[ports.Seat, ...]) -> Transport:
    transport = _open_transport(options, seats)
    if options.signing_keys is None:
        return transport
    from sim_vehicles.clock import unix_us
    from sim_vehicles.sealed import SealedTransport

    systems = [seat.system for seat in seats]
    return SealedTransport(transport, systems, options.signing_keys, unix_us)


def _open_transport(options: Options, seats: tuple[ports.Seat, ...]) -> Transport:
    first = _first_transport(options, seats)
    if options.gcs is None:
        return first
    from sim_vehicles.transport import Both
    from sim_vehicles.udp import UdpPorts

    host, port = options.gcs
    return Both(first, UdpPorts(host, [port] * len(seats)))


def _first_transport(options: Options, seats: tuple[ports.Seat, ...]) -> Transport:
    if options.tcp:
        from sim_vehicles.tcp import TcpPorts

        return TcpPorts(options.host, seats)
    from sim_vehicles.udp import UdpPorts

    return UdpPorts(options.host, [seat.port for seat in seats])


async def _fly(
    options: Options,
    seats: tuple[ports.Seat, ...],
    fleet: Fleet,
    transport: Transport,
) -> Report:
    """Show the table and serve until SIGINT or SIGTERM; a second signal ends the process."""
    from sim_vehicles.server import serve

    loop = asyncio.get_running_loop()
    stop = asyncio.Event()

    def end(number: signal.Signals) -> None:
        stop.set()
        loop.remove_signal_handler(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, end, number)
    _show(options, seats)
    return await serve(
        fleet,
        transport,
        speed=options.speed,
        duration_s=options.duration,
        on_step=None if options.as_json else _tell_when_ready(fleet),
        stop=stop,
    )


def _tell_when_ready(fleet: Fleet) -> Callable[[Fleet, int], None]:
    """Says once that the position estimates are good, for people who want to arm."""
    ready_us = int(fleet.pilot.status.ready_us.max())
    told = False

    def look(_fleet: Fleet, t_us: int) -> None:
        nonlocal told
        if not told and t_us >= ready_us:
            told = True
            click.echo(f"ready to arm, {t_us / 1e6:.1f} s after the start")

    return look


def _show(options: Options, seats: tuple[ports.Seat, ...]) -> None:
    """Ids, kinds and ports, before the first frame goes out."""
    wire = "tcp, listening on" if options.tcp else "udp, sending to"
    if options.as_json:
        vehicles = [
            {"id": seat.system, "kind": options.kind, "host": options.host, "port": seat.port}
            for seat in seats
        ]
        click.echo(json.dumps({"protocol": wire[:3], "speed": options.speed, "vehicles": vehicles}))
        return
    click.echo(f"{'id':>9}  {'kind':8}  {'autopilot':9}  {wire}")
    groups: dict[int, list[int]] = {}
    for seat in seats:
        groups.setdefault(seat.port, []).append(seat.system)
    rows = [
        f"{_span(systems):>9}  {options.kind:8}  {options.autopilot:9}  {options.host}:{port}"
        for port, systems in groups.items()
    ]
    if len(rows) > _ROWS:
        rows[_ROWS // 2 : -_ROWS // 2] = [f"{'..':>9}"]
    for row in rows:
        click.echo(row)
    many = f"{options.count} vehicles" if options.count > 1 else "1 vehicle"
    click.echo(f"{many} at {options.speed:g} times real time; Ctrl-C ends")


def _span(systems: list[int]) -> str:
    return str(systems[0]) if len(systems) == 1 else f"{systems[0]}-{systems[-1]}"


def _sum_up(options: Options, fleet: Fleet, report: Report) -> None:
    """What happened, at the end."""
    traffic = report.traffic
    frames = sum(counts.packets for counts in fleet.counts)
    garbage = traffic.garbage + sum(counts.garbage for counts in fleet.counts)
    if options.as_json:
        values = {
            "simulated_s": report.simulated_s,
            "wall_s": report.wall_s,
            "rate": report.rate,
            "datagrams_out": traffic.datagrams_out,
            "bytes_out": traffic.bytes_out,
            "dropped": traffic.dropped,
            "datagrams_in": traffic.datagrams_in,
            "bytes_in": traffic.bytes_in,
            "frames_in": frames,
            "garbage_in": garbage,
        }
        click.echo(json.dumps(values))
        return
    click.echo(
        f"{report.simulated_s:.1f} s simulated in {report.wall_s:.1f} s (x{report.rate:.3g}); "
        f"out: {traffic.datagrams_out} datagrams, {traffic.bytes_out} bytes, "
        f"{traffic.dropped} dropped; in: {traffic.datagrams_in} datagrams, {frames} frames, "
        f"{garbage} pieces of garbage"
    )
