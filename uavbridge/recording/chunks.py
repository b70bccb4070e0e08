"""An MCAP file, written chunk by chunk; https://mcap.dev/spec.

What comes often (messages, chunks, their indexes) is packed here at once, which takes a quarter of
the mcap package's time; what comes once is left to the package's records.
"""

from __future__ import annotations

import zlib
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from io import BufferedWriter
from struct import Struct, pack

import lz4.frame
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

CHUNK_BYTES = 512 * 1024
COMPRESSION = "lz4"
_MESSAGE = Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_CHUNK = Struct("<BQQQQII3sQ")  # then the records
_INDEX = Struct("<BQHI")  # then log time and offset of each message
_HEAD_BYTES = _MESSAGE.size - 9  # of a message's length that are not data


@dataclass(slots=True)
class _Open:
    """The chunk in progress: its records and where each channel's messages are in it."""

    parts: list[bytes]
    index: defaultdict[int, list[int]]
    size: int = 0
    first_ns: int = 0
    last_ns: int = 0


class ChunkedFile:
    """Writes to a stream, from its beginning.

    Args:
        stream: where to.
        library: that wrote it, for people.
        name: of a metadata record.
        metadata: that record.
    """

    def __init__(
        self, stream: BufferedWriter, library: str, name: str, metadata: Mapping[str, str]
    ) -> None:
        self._stream = stream
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._counts: Counter[int] = Counter()
        self._open = _Open([], defaultdict(list))
        stream.write(MCAP0_MAGIC)
        self._write(Header(profile="", library=library))
        offset = stream.tell()
        length = self._write(Metadata(name=name, metadata=dict(metadata)))
        self._metadata = MetadataIndex(offset=offset, length=length, name=name)

    def schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema; its id."""
        schema = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._schemas.append(schema)
        self._chunked(schema)
        return int(schema.id)

    def channel(self, topic: str, encoding: str, schema: int) -> int:
        """Add a channel; its id."""
        number = len(self._channels) + 1
        channel = Channel(
            id=number, topic=topic, message_encoding=encoding, metadata={}, schema_id=schema
        )
        self._channels.append(channel)
        self._chunked(channel)
        return number

    def add(self, channel: int, date_ns: int, data: bytes) -> None:
        """Add a message of a date in Unix nanoseconds."""
        chunk = self._open
        if not chunk.index:
            chunk.first_ns = chunk.last_ns = date_ns
        elif date_ns > chunk.last_ns:
            chunk.last_ns = date_ns
        elif date_ns < chunk.first_ns:
            chunk.first_ns = date_ns
        head = _MESSAGE.pack(Opcode.MESSAGE, _HEAD_BYTES + len(data), channel, 0, date_ns, date_ns)
        chunk.parts += (head, data)
        chunk.index[channel] += (date_ns, chunk.size)
        chunk.size += _MESSAGE.size + len(data)
        if chunk.size > CHUNK_BYTES:
            self._close_chunk()

    def flush(self) -> None:
        """End the chunk in progress and hand all to the operating system."""
        self._close_chunk()
        self._stream.flush()

    def finish(self) -> None:
        """Write the index at the end."""
        self._close_chunk()
        self._write(DataEnd(data_section_crc=0))
        start, summary, offsets = self._stream.tell(), RecordBuilder(), []
        chunks = self._chunks
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=dict(self._counts),
            chunk_count=len(chunks),
            message_count=self._counts.total(),
            metadata_count=1,
            message_start_time=min((c.message_start_time for c in chunks), default=0),
            message_end_time=max((c.message_end_time for c in chunks), default=0),
            schema_count=len(self._schemas),
        )
        groups: tuple[tuple[int, list[McapRecord]], ...] = (
            (Opcode.SCHEMA, [*self._schemas]),
            (Opcode.CHANNEL, [*self._channels]),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, [*chunks]),
            (Opcode.METADATA_INDEX, [self._metadata]),
        )
        for code, records in groups:
            before = summary.count
            for record in records:
                record.write(summary)
            if records:
                length = summary.count - before
                offsets.append(
                    SummaryOffset(
                        group_opcode=code, group_start=start + before, group_length=length
                    )
                )
        offsets_start = start + summary.count
        for offset in offsets:
            offset.write(summary)
        data = _end(summary)
        footer = pack("<BQQQ", Opcode.FOOTER, 20, start, offsets_start)
        self._stream.write(data)
        self._write(
            Footer(
                summary_start=start,
                summary_offset_start=offsets_start,
                summary_crc=zlib.crc32(footer, zlib.crc32(data)),
            )
        )
        self._stream.write(MCAP0_MAGIC)

    def _write(self, record: McapRecord) -> int:
        data = _bytes(record)
        self._stream.write(data)
        return len(data)

    def _chunked(self, record: McapRecord) -> None:
        data = _bytes(record)
        self._open.parts.append(data)
        self._open.size += len(data)

    def _close_chunk(self) -> None:
        chunk = self._open
        if not chunk.index:
            return
        self._open = _Open([], defaultdict(list))
        records = b"".join(chunk.parts)
        packed = lz4.frame.compress(records)
        start = self._stream.tell()
        head = _CHUNK.pack(
            Opcode.CHUNK,
            _CHUNK.size - 9 + len(packed),
            chunk.first_ns,
            chunk.last_ns,
            len(records),
            zlib.crc32(records),
            len(COMPRESSION),
            COMPRESSION.encode(),
            len(packed),
        )
        at = start + len(head) + len(packed)
        offsets: dict[int, int] = {}
        indexes: list[bytes] = []
        indexed = 0
        for channel, places in chunk.index.items():
            offsets[channel] = at + indexed
            self._counts[channel] += len(places) // 2
            length = 8 * len(places)
            index = _INDEX.pack(Opcode.MESSAGE_INDEX, 6 + length, channel, length)
            indexes += (index, pack(f"<{len(places)}Q", *places))
            indexed += len(index) + length
        self._stream.write(b"".join((head, packed, *indexes)))
        self._chunks.append(
            ChunkIndex(
                chunk_length=len(head) + len(packed),
                chunk_start_offset=start,
                compression=COMPRESSION,
                compressed_size=len(packed),
                message_end_time=chunk.last_ns,
                message_index_length=indexed,
                message_index_offsets=offsets,
                message_start_time=chunk.first_ns,
                uncompressed_size=len(records),
            )
        )


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return _end(builder)


def _end(builder: RecordBuilder) -> bytes:
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data
