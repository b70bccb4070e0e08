"""A launched bridge as a process of its own, and a pilot beside it."""

import json
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

from sim_vehicles.codec import Counts, Encoder, StreamDecoder, mav

HOLD, RTL = (4, 3), (4, 5)  # PX4's modes


class Bridge:
    """A running ``uavbridge launch``: what it says, and how it ends."""

    def __init__(self, process, out):
        self.process = process
        self.out = Path(out or "")
        self.lines = []
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            with self._changed:
                self.lines.append(line.rstrip())
                self._changed.notify_all()
        with self._changed:
            self._changed.notify_all()

    @property
    def text(self):
        return " ".join(" ".join(self.lines).split())

    def until(self, *words, limit_s=60.0):
        """Wait until it has said all of them."""
        end = time.monotonic() + limit_s
        with self._changed:
            while not all(word in self.text for word in words):
                left = end - time.monotonic()
                assert left > 0, f"never said {words}: {self.text}"
                assert self.process.poll() is None or all(w in self.text for w in words), self.text
                self._changed.wait(min(left, 0.5))

    @property
    def router(self):
        self.until("zenoh router")
        return re.search(r"zenoh router (tcp/\S+:\d+)", self.text)[1]

    def command(self, verb, *arguments):
        """An operator's order; the replies."""
        done = subprocess.run(
            [sys.executable, "-m", "uavbridge", "command", verb, *map(str, arguments),
             "--router", self.router, "--json"],
            capture_output=True, text=True, timeout=30, check=False,
        )  # fmt: skip
        return json.loads(done.stdout)

    def interrupt(self):
        self.process.send_signal(signal.SIGINT)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def close(self):
        self._reader.join(10)
        self.process.stdout.close()

    def end(self, limit_s=90.0):
        """Its summary, once it is over."""
        self.process.wait(limit_s)
        assert "Traceback" not in self.text
        return json.loads((self.out / "summary.json").read_text())


@contextmanager
def bridge(out, *arguments):
    process = subprocess.Popen(
        [sys.executable, "-m", "uavbridge", "-v", "launch", *map(str, arguments),
         "--headless", *(() if out is None else ("--out", str(out)))],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    flown = Bridge(process, out)
    try:
        yield flown
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()
        flown.close()


class Pilot:
    """A ground station on the vehicle's TCP port."""

    def __init__(self, port, system=1):
        self._socket = socket.create_connection(("127.0.0.1", port))
        self._socket.settimeout(0.2)
        self._encoder = Encoder(255, 190)
        self._decoder = StreamDecoder()
        self.system = system
        self.newest = {}
        self.texts = []

    def look(self, seconds=0.5):
        """Take in what the vehicle says for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                data = self._socket.recv(1 << 16)
            except TimeoutError:
                continue
            for packet in self._decoder.feed(data, Counts()):
                self.newest[packet.message.msgname] = packet.message
                if packet.message.msgname == "STATUSTEXT":
                    self.texts.append(packet.message.text)

    def until(self, condition, limit_s=30.0):
        end = time.monotonic() + limit_s
        while "HEARTBEAT" not in self.newest or not condition(self):
            assert time.monotonic() < end, (self.newest, self.texts)
            self.look(0.2)

    def mode(self, main, sub=0):
        self.command(176, 1, main, sub)

    def command(self, number, *params):
        values = [*params, 0, 0, 0, 0, 0, 0, 0][:7]
        fields = {f"param{i + 1}": float(value) for i, value in enumerate(values)}
        self._send("COMMAND_LONG", command=number, target_component=1, **fields)

    def ask(self, name):
        """Ask for a parameter; its answer's wire value."""
        self.newest.pop("PARAM_VALUE", None)
        self._send("PARAM_REQUEST_READ", param_id=name, param_index=-1, target_component=1)
        self.until(lambda me: getattr(me.newest.get("PARAM_VALUE"), "param_id", "") == name)
        return self.newest["PARAM_VALUE"].param_value

    def set(self, name, value, kind=9):
        self._send("PARAM_SET", param_id=name, param_value=value, param_type=kind,
                   target_component=1)  # fmt: skip

    def _send(self, name, **fields):
        self._socket.sendall(self._encoder.pack(name, target_system=self.system, **fields))

    @property
    def flown_mode(self):
        """(main, sub) of PX4's heartbeat."""
        number = self.newest["HEARTBEAT"].custom_mode
        return number >> 16 & 255, number >> 24

    @property
    def armed(self):
        return bool(self.newest["HEARTBEAT"].base_mode & mav.MAV_MODE_FLAG_SAFETY_ARMED)

    def close(self):
        self._socket.close()
