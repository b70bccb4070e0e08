"""The codec against pymavlink, and against bytes that no vehicle ever sent."""

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim_vehicles.codec import BatchPacker, Counts, Encoder, StreamDecoder, decode, mav
from sim_vehicles.codec.tables import BY_ID, BY_NAME, Layout

MESSAGES = sorted(mav.mavlink_map)


def values_of(layout: Layout, payload: bytes) -> dict[str, object]:
    """Named values from the bytes of a payload; texts stay bytes."""
    flat = list(struct.unpack(layout.struct.format, payload))
    values: dict[str, object] = {}
    for field in layout.fields:
        if field.count and field.code != "s":
            values[field.name] = tuple(flat[: field.count])
            del flat[: field.count]
        else:
            values[field.name] = flat.pop(0)
    return values


def packed_by_pymavlink(
    layout: Layout, values: dict, *, system=1, component=1, sequence=0
) -> bytes:
    sender = mav.MAVLink(None, system, component)
    sender.seq = sequence
    return bytes(mav.mavlink_map[layout.msgid](**values).pack(sender))


@st.composite
def payloads(draw) -> tuple[Layout, bytes]:
    """A message and its payload: any bytes, often with zeros at the end."""
    layout = BY_ID[draw(st.sampled_from(MESSAGES))]
    size = layout.struct.size
    used = draw(st.integers(0, size))
    return layout, draw(st.binary(min_size=used, max_size=used)).ljust(size, b"\0")


def same(ours: object, theirs: object) -> bool:
    """Equal, NaN being equal to NaN."""
    return repr(ours) == repr(theirs)


@settings(max_examples=400)
@given(payloads(), st.integers(1, 255), st.integers(0, 255), st.integers(0, 255))
def test_frames_are_those_of_pymavlink(message, system, component, sequence):
    layout, payload = message
    values = values_of(layout, payload)
    encoder = Encoder(system, component)
    encoder.sequence = sequence
    frame = encoder.pack(layout.name, **values)
    assert frame == packed_by_pymavlink(
        layout, values, system=system, component=component, sequence=sequence
    )
    assert encoder.sequence == (sequence + 1) % 256


@pytest.mark.parametrize("msgid", MESSAGES)
def test_every_message_is_read_as_pymavlink_reads_it(msgid):
    layout = BY_ID[msgid]
    rng = np.random.default_rng(msgid)
    for keep in (layout.struct.size, layout.struct.size // 2, 0):
        payload = rng.bytes(keep).ljust(layout.struct.size, b"\0")
        frame = packed_by_pymavlink(layout, values_of(layout, payload), system=7, sequence=3)
        counts = Counts()
        (packet,) = decode(frame, counts)
        theirs = mav.MAVLink(None).parse_char(frame)
        assert counts == Counts(packets=1)
        assert packet[:3] == (7, 1, 3)
        assert packet.raw == frame
        assert type(packet.message).__name__ == packet.message.msgname == theirs.get_type()
        assert packet.message.msgid == msgid
        for field in layout.fields:
            ours, expected = getattr(packet.message, field.name), getattr(theirs, field.name)
            if field.code == "s":
                assert "\0" not in ours
            elif field.count:
                assert same(list(ours), list(expected)), field
            else:
                assert same(ours, expected), field


@given(st.text(max_size=40))
def test_texts_survive(text):
    text = text.partition("\0")[0].encode()[:50].decode(errors="ignore")
    frame = Encoder(1).pack("STATUSTEXT", severity=6, text=text)
    (packet,) = decode(frame, Counts())
    assert packet.message.text == text


def test_a_text_ends_at_its_first_nul_and_bad_bytes_do_not_raise():
    frame = Encoder(1).pack("STATUSTEXT", text=b"ab\xff\0cd")
    assert decode(frame, Counts())[0].message.text == "ab\N{REPLACEMENT CHARACTER}"


@pytest.mark.parametrize(
    ("name", "fields", "says"),
    [
        ("NO_SUCH_THING", {}, "NO_SUCH_THING"),
        ("HEARTBEAT", {"typ": 1}, "HEARTBEAT has no field typ"),
        ("HEARTBEAT", {"type": 256}, "HEARTBEAT.type"),
        ("HEARTBEAT", {"type": 1.5}, "HEARTBEAT.type"),
        ("HEARTBEAT", {"custom_mode": -1}, "HEARTBEAT.custom_mode"),
        ("ATTITUDE", {"pitch": 1e300}, "ATTITUDE.pitch"),
        ("ATTITUDE", {"pitch": "up"}, "ATTITUDE.pitch"),
        ("STATUSTEXT", {"text": "x" * 51}, "STATUSTEXT.text"),
        ("BATTERY_STATUS", {"voltages": (1, 2)}, "BATTERY_STATUS.voltages"),
        ("BATTERY_STATUS", {"voltages": (70000,) * 10}, "BATTERY_STATUS.voltages"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(name, fields, says):
    encoder = Encoder(1)
    with pytest.raises(ValueError, match=says):
        encoder.pack(name, **fields)
    assert encoder.sequence == 0


def test_ids_out_of_range_are_refused():
    with pytest.raises(ValueError, match="256"):
        Encoder(256)
    with pytest.raises(ValueError, match="-1"):
        Encoder(1, -1)


HEARTBEAT = Encoder(9).pack("HEARTBEAT", type=2, autopilot=12)
COMMAND = Encoder(255, 190).pack("COMMAND_LONG", command=400, param1=1.0)


@given(st.binary(max_size=400))
def test_any_bytes_are_survived(data):
    counts = Counts()
    decode(data, counts)
    assert counts.packets + counts.garbage > 0 or not data
    StreamDecoder().feed(data, counts)


def test_noise_never_becomes_a_message():
    rng = np.random.default_rng(5)
    counts = Counts()
    for _ in range(3000):
        data = bytearray(rng.bytes(int(rng.integers(12, 280))))
        data[0] = 0xFD
        assert decode(bytes(data), counts) == []
    assert counts.packets == 0
    assert counts.garbage >= 3000


@given(st.integers(1, len(COMMAND) - 1))
def test_truncated_frames_are_dropped_and_counted(size):
    counts = Counts()
    assert decode(COMMAND[:size], counts) == []
    assert counts.truncated >= 1


@given(st.integers(0, len(COMMAND) - 1), st.integers(1, 255))
def test_a_flipped_byte_is_never_believed(place, change):
    data = bytearray(COMMAND)
    data[place] ^= change
    counts = Counts()
    assert decode(bytes(data), counts) == []
    assert counts.garbage >= 1


@given(st.binary(max_size=60))
def test_good_frames_after_noise_are_found(noise):
    noise = noise.replace(b"\xfd", b"").replace(b"\xfe", b"")
    counts = Counts()
    packets = decode(noise + HEARTBEAT + COMMAND, counts)
    assert [packet.message.msgname for packet in packets] == ["HEARTBEAT", "COMMAND_LONG"]
    assert counts == Counts(packets=2, noise=len(noise))


def test_a_bad_frame_costs_only_itself():
    broken = bytearray(COMMAND)
    broken[20] ^= 1
    counts = Counts()
    packets = decode(HEARTBEAT + bytes(broken) + HEARTBEAT, counts)
    assert len(packets) == 2
    assert counts.bad_crc >= 1


def test_a_false_start_does_not_hide_a_frame_behind_it():
    counts = Counts()
    packets = decode(b"\xfd\xff" + HEARTBEAT, counts)
    assert len(packets) == 1
    assert counts.garbage >= 1


def unknown_frame(msgid: int = 0xABCDEF) -> bytes:
    return b"\xfd\x02\0\0\0\x01\x01" + msgid.to_bytes(3, "little") + b"\x01\x02" + b"\x33\x44"


def test_unknown_messages_are_dropped_and_counted():
    counts = Counts()
    packets = decode(HEARTBEAT + unknown_frame() + COMMAND + unknown_frame(), counts)
    assert [packet.message.msgname for packet in packets] == ["HEARTBEAT", "COMMAND_LONG"]
    assert counts == Counts(packets=2, unknown=2)


def test_mavlink_1_frames_are_read():
    sender = mav.MAVLink(None, 4, 5)
    message = mav.MAVLink_command_long_message(1, 1, 400, 0, 1.0, 0, 0, 0, 0, 0, 2.5)
    frame = bytes(message.pack(sender, force_mavlink1=True))
    assert frame[0] == 0xFE
    counts = Counts()
    packets = decode(frame + HEARTBEAT + frame, counts)
    assert [packet.system for packet in packets] == [4, 9, 4]
    assert packets[0].message.param7 == 2.5
    assert packets[0].raw == frame
    broken = frame[:-1] + bytes([frame[-1] ^ 1])
    assert decode(broken, counts) == []
    assert counts.bad_crc == 1


def test_signed_frames_are_read_without_verifying():
    sender = mav.MAVLink(None, 4, 5)
    sender.signing.secret_key = bytes(32)
    sender.signing.sign_outgoing = True
    frame = bytes(mav.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3).pack(sender))
    assert frame[2] == 1
    counts = Counts()
    packets = decode(frame + COMMAND, counts)
    assert [packet.message.msgname for packet in packets] == ["HEARTBEAT", "COMMAND_LONG"]
    assert packets[0].raw == frame
    assert counts == Counts(packets=2)


def test_frames_with_flags_we_do_not_know_are_dropped():
    frame = bytearray(HEARTBEAT)
    frame[2] = 0x02
    crc = mav.x25crc(bytes(frame[1:-2]) + bytes([mav.mavlink_map[0].crc_extra])).crc
    frame[-2:] = struct.pack("<H", crc)
    counts = Counts()
    assert decode(bytes(frame) + HEARTBEAT, counts)[0].message.msgname == "HEARTBEAT"
    assert counts == Counts(packets=1, unknown=1)


@given(st.lists(st.integers(1, 40), max_size=60), st.data())
def test_a_stream_may_be_cut_anywhere(sizes, data):
    names = data.draw(
        st.lists(st.sampled_from(["HEARTBEAT", "ATTITUDE", "STATUSTEXT"]), max_size=8)
    )
    encoder = Encoder(3)
    stream = b"".join(encoder.pack(name) for name in names)
    decoder, counts, heard = StreamDecoder(), Counts(), []
    at = 0
    for size in [*sizes, len(stream)]:
        heard += decoder.feed(stream[at : at + size], counts)
        at += size
    assert [packet.message.msgname for packet in heard] == names
    assert [packet.sequence for packet in heard] == list(range(len(names)))
    assert counts == Counts(packets=len(names))


def test_counts_add_up():
    total = Counts(packets=1, noise=2)
    total.add(Counts(packets=3, bad_crc=1, truncated=4, unknown=5))
    assert total == Counts(packets=4, bad_crc=1, truncated=4, unknown=5, noise=2)
    assert total.garbage == 12


@settings(max_examples=150)
@given(
    st.lists(st.sampled_from(MESSAGES), min_size=1, max_size=4, unique=True),
    st.integers(1, 5),
    st.integers(0, 2**32 - 1),
)
def test_batches_are_the_same_bytes(msgids, n, seed):
    rng = np.random.default_rng(seed)
    layouts = [BY_ID[msgid] for msgid in msgids]
    packer = BatchPacker(*(layout.name for layout in layouts), component=42)
    records = packer.records(n)
    systems = rng.integers(1, 256, n).astype(np.uint8)
    sequences = rng.integers(0, 256, n).astype(np.uint8)
    expected = [b""] * n
    for at, layout in enumerate(layouts):
        size = layout.struct.size
        for i in range(n):
            payload = rng.bytes(int(rng.integers(0, size + 1))).ljust(size, b"\0")
            for name, value in values_of(layout, payload).items():
                records[layout.name][name][i] = value
            fields = {  # what the record kept: it can not hold every NaN
                field.name: records[layout.name][field.name][i] for field in layout.fields
            }
            expected[i] += packed_by_pymavlink(
                layout,
                {name: value.tolist() for name, value in fields.items()},
                system=int(systems[i]),
                component=42,
                sequence=(int(sequences[i]) + at) % 256,
            )
    assert packer.pack(records, systems, sequences) == expected
    assert packer.pack(records, systems, sequences) == expected  # records are as they were


def test_neighbouring_fields_can_be_filled_together():
    packer = BatchPacker("ATTITUDE")
    records = packer.records(2)
    records["ATTITUDE"]["roll:yawspeed"] = np.arange(12).reshape(2, 6)
    ids = np.array([1, 2], dtype=np.uint8)
    messages = [decode(frame, Counts())[0].message for frame in packer.pack(records, ids, ids)]
    assert messages[1] == (0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0)


def test_names_and_ids_lead_to_the_same_layout():
    for msgid in MESSAGES:
        layout = BY_ID[msgid]
        assert BY_NAME[layout.name] is layout
