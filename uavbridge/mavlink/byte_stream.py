"""What links over streams of bytes have in common: frames cut out, what waits to be sent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from sim_vehicles.codec import Counts, StreamDecoder

_MOST_CHUNKS: Final = 64


class ByteStream:
    """One connection of a link, from its beginning to its end.

    Args:
        read: bytes that came; none: the other side has ended. Raises BlockingIOError or OSError.
        write: how many of the bytes were taken. Raises likewise.
        end: called with the reason when the connection is over.
        ended: the reason when the other side has ended.
        counts: of what was good and bad.
        most_unsent: bytes that may wait; what comes next is lost, as on a radio.
    """

    def __init__(
        self,
        read: Callable[[], bytes],
        write: Callable[[bytes], int],
        end: Callable[[str], None],
        *,
        ended: str,
        counts: Counts,
        most_unsent: int,
    ) -> None:
        self._read, self._write, self._end, self._ended = read, write, end, ended
        self._counts, self._most_unsent = counts, most_unsent
        self._decoder = StreamDecoder()
        self._unsent = b""

    def send(self, data: bytes) -> bool:
        """Send now or later; False: too much waits already."""
        if len(self._unsent) > self._most_unsent:
            return False
        self._unsent += data
        self._flush()
        return True

    def _flush(self) -> None:
        try:
            sent = self._write(self._unsent)
        except BlockingIOError:
            return
        except OSError as error:
            self._end(error.strerror or str(error))
            return
        self._unsent = self._unsent[sent:]

    def receive(self) -> list[bytes]:
        """Whole frames that came; what waits is sent on the way."""
        if self._unsent:
            self._flush()
        frames: list[bytes] = []
        for _ in range(_MOST_CHUNKS):
            try:
                data = self._read()
            except BlockingIOError:
                break
            except OSError as error:
                self._end(error.strerror or str(error))
                break
            if not data:
                self._end(self._ended)
                break
            frames += [packet.raw for packet in self._decoder.feed(data, self._counts)]
        return frames
