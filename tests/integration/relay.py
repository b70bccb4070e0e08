"""A bad link: passes UDP datagrams both ways, and does to them what it is told."""

import random
import socket
import threading
from contextlib import contextmanager

from sim_vehicles.codec import Counts, decode


class Relay:
    """Vehicles send to ``port``; it passes everything on to ``target`` and back."""

    def __init__(self, target):
        self._near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._near.bind(("127.0.0.1", 0))
        self.port = self._near.getsockname()[1]
        self._target = ("127.0.0.1", target)
        self._vehicle = None
        self._far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._far.bind(("127.0.0.1", 0))
        self._rng = random.Random(7)
        self.loss = self.trouble = 0.0
        self.down = self.deaf = False
        """Nothing passes; nothing passes to the vehicle."""
        self.without = frozenset()  # names of messages that do not come from the vehicle
        self.swallows = {}  # name of a message -> how many more of them are lost, from the vehicle
        self._closed = False
        self._threads = [
            threading.Thread(target=self._pass, args=way, daemon=True)
            for way in ((self._near, True), (self._far, False))
        ]
        for thread in self._threads:
            thread.start()

    def _pass(self, source, from_vehicle):
        source.settimeout(0.2)
        late = []
        while not self._closed:
            try:
                data, sender = source.recvfrom(65535)
            except TimeoutError:
                continue
            except OSError:
                return
            if from_vehicle:
                self._vehicle = sender
            if self.down or (self.deaf and not from_vehicle) or self._rng.random() < self.loss:
                continue
            if from_vehicle and (self.without or self.swallows):
                data = b"".join(
                    p.raw for p in decode(data, Counts()) if self._lets(p.message.msgname)
                )
            out = self._spoiled(data, late) if self.trouble else [data]
            for each in out:
                if from_vehicle:
                    self._far.sendto(each, self._target)
                elif self._vehicle is not None:
                    self._near.sendto(each, self._vehicle)

    def _lets(self, name):
        left = self.swallows.get(name, 0)
        if left:
            self.swallows[name] = left - 1
        return not left and name not in self.without

    def _spoiled(self, data, late):
        drawn = self._rng.random() / self.trouble
        before, late[:] = list(late), []
        if drawn < 0.25:
            return [data, data, *before]
        if drawn < 0.5:
            late.append(data)
            return before
        if drawn < 0.75:
            broken = bytearray(data)
            broken[self._rng.randrange(len(broken))] ^= 0x55
            return [bytes(broken), *before]
        if drawn < 1.0:
            return [data[: len(data) // 2], b"\xfd noise", data, *before]
        return [data, *before]

    def close(self):
        self._closed = True
        for thread in self._threads:
            thread.join(2)
        self._near.close()
        self._far.close()


@contextmanager
def relay(target):
    made = Relay(target)
    try:
        yield made
    finally:
        made.close()
