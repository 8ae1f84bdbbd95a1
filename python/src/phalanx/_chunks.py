"""The samples of an MCAP file, chunk by chunk: what is alike is taken in one go by NumPy instead of message by message."""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

import lz4.frame
import numpy as np
import numpy.typing as npt
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema
from numpy.lib.stride_tricks import sliding_window_view

#: What an MCAP file starts with.
_MAGIC = b"\x89MCAP0\r\n"
#: Opcode and length before every record, bytes.
_PREFIX = 1 + 8
#: Bytes of a message record before its data: prefix, channel, sequence, two times.
_RECORD = _PREFIX + 2 + 4 + 8 + 8
#: Where its time stands.
_TIME = _PREFIX + 2 + 4
#: CDR, little-endian.
_ENCAPSULATION = 4
#: Where a run says what has happened to participants.
_EVENTS = "/phalanx/events"
#: What reading damaged bytes raises.
_DAMAGE = (ValueError, IndexError, KeyError, EOFError, RuntimeError, struct.error, zstandard.ZstdError, McapError)
#: A field of a schema: ``float64[3] position  # m``.
_FIELD = re.compile(r"float64(?:\[(\d+)\])? ([a-z][a-z0-9_]*)(?:  # (.*))?$")
#: The first fields of every sample.
_HEADER = ["builtin_interfaces/Time stamp", "uint64 step", "uint32 agent", "uint32 status"]


@dataclass(frozen=True)
class Field:
    """A field of a topic."""

    name: str
    width: int
    scalar: bool
    unit: str


@dataclass
class Raw:
    """The samples of a topic."""

    topic: str
    fields: list[Field]
    #: Time of every sample, ns.
    times: npt.NDArray[np.uint64]
    #: Samples as they stand in the file.
    samples: npt.NDArray[np.void]


@dataclass(frozen=True)
class Event:
    """Something that happened to a participant."""

    time: float
    step: int
    participant: str
    text: str

    @classmethod
    def read(cls, message: bytes) -> Event:
        """Reads a message of the topic ``/phalanx/events``."""
        sec, nanosec, step = struct.unpack_from("<iIQ", message, _ENCAPSULATION)
        texts, at = [], _ENCAPSULATION + 16
        for _ in range(2):
            # Behind the encapsulation, lengths stand at multiples of four.
            at += -(at - _ENCAPSULATION) % 4
            (length,) = struct.unpack_from("<I", message, at)
            texts.append(message[at + 4 : at + 3 + length].decode(errors="replace"))
            at += 4 + length
        return cls(sec + nanosec / 1e9, step, *texts)


@dataclass
class Content:
    """What a log holds."""

    complete: bool = False
    scenario: str = ""
    metadata: dict[str, str] = field(default_factory=dict)
    players: list[dict[str, str]] = field(default_factory=list)
    channels: list[Raw] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    #: What is wrong with the file, if it is damaged; what stands before that place is there.
    damage: str = ""


def fields_of(schema: Schema) -> list[Field] | None:
    """The fields of a sample; ``None`` if messages of this type are something else."""
    if schema.encoding != "ros2msg":
        return None
    lines = schema.data.decode().split("=" * 80)[0].splitlines()
    if [line.split("  # ")[0] for line in lines[: len(_HEADER)]] != _HEADER:
        return None
    matches = [_FIELD.match(line) for line in lines[len(_HEADER) :]]
    if None in matches:
        return None
    return [Field(m[2], int(m[1] or 1), m[1] is None, m[3] or "") for m in matches if m]


class _Collector:
    """Samples of one channel while the file is read."""

    def __init__(self, topic: str, fields: list[Field]) -> None:
        words = sum(field.width for field in fields)
        self.topic, self.fields = topic, fields
        header = [("sec", "<i4"), ("nanosec", "<u4"), ("step", "<u8"), ("agent", "<u4"), ("status", "<u4")]
        self.type = np.dtype([*header, ("words", "<f8", (words,))])
        self.parts: list[npt.NDArray[np.uint8]] = []
        self.times: list[npt.NDArray[np.uint64]] = []

    def take(self, chunk: npt.NDArray[np.uint8], index: npt.NDArray[np.uint64]) -> None:
        """Takes the messages of a chunk, of which the index lists times and places."""
        times, places = index.T
        stamps = sliding_window_view(chunk, 8)[places.astype(np.intp) + _TIME].view("<u8")[:, 0]
        if (chunk[places.astype(np.intp)] != Opcode.MESSAGE).any() or (stamps != times).any():
            raise ValueError("its index does not fit")
        starts = places.astype(np.intp) + _RECORD + _ENCAPSULATION
        self.parts.append(sliding_window_view(chunk, self.type.itemsize)[starts])
        self.times.append(times)

    def finish(self, rows: int) -> Raw:
        empty = np.empty((0, self.type.itemsize), np.uint8)
        samples = np.concatenate([empty, *self.parts])[:rows].reshape(-1).view(self.type)
        times = np.concatenate([np.empty(0, np.uint64), *self.times])[:rows]
        samples.flags.writeable = times.flags.writeable = False
        return Raw(self.topic, self.fields, times, samples)

    def rows(self) -> int:
        return sum(map(len, self.times))


def read(path: Path) -> Content:
    """Reads all samples; of a file that was cut, all that is whole.

    Raises `FileNotFoundError`, and `ValueError` if it is no log of this project.
    """
    data = path.read_bytes()
    if not data.startswith(_MAGIC):
        raise ValueError(f"{path} is not an MCAP file; give a log that `phalanx run` recorded")
    content, definitions = Content(), _Definitions()
    chunk = np.empty(0, np.uint8)
    for opcode, body in _records(memoryview(data)[len(_MAGIC) :]):
        match opcode:
            case Opcode.CHUNK if not content.damage:
                try:
                    chunk = _unpack(Chunk.read(_stream(body)))
                    definitions.look_into(chunk)
                except _DAMAGE as error:
                    content.damage = f"a chunk of {path} cannot be read: {error}"
            case Opcode.MESSAGE_INDEX if not content.damage:
                channel = int.from_bytes(body[:2], "little")
                if channel in definitions.collectors:
                    # Number of the channel, length of what follows, then pairs of time and place.
                    index = np.frombuffer(body[6:], "<u8").reshape(-1, 2)
                    try:
                        definitions.collectors[channel].take(chunk, index)
                    except _DAMAGE as error:
                        content.damage = f"a chunk of {path} cannot be read: {error}"
                elif channel == definitions.events:
                    content.events += [event_at(chunk, int(place)) for _, place in np.frombuffer(body[6:], "<u8").reshape(-1, 2)]
            case Opcode.ATTACHMENT:
                attachment = Attachment.read(_stream(body))
                if attachment.name == "scenario.toml":
                    content.scenario = attachment.data.decode()
            case Opcode.METADATA:
                metadata = Metadata.read(_stream(body))
                if metadata.name == "phalanx":
                    content.metadata = dict(metadata.metadata)
                elif metadata.name == "phalanx-player":
                    content.players.append(dict(metadata.metadata))
            case Opcode.FOOTER:
                content.complete = not content.damage
            case Opcode.CHUNK | Opcode.MESSAGE_INDEX:
                pass
            case _:
                definitions.take(opcode, body)
    collectors = definitions.collectors.values()
    if not collectors:
        raise ValueError(f"{path} holds no samples of `phalanx run`")
    rows = min(collector.rows() for collector in collectors)
    content.channels = [collector.finish(rows) for collector in collectors]
    return content


def _records(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Opcode and body of every record that is whole."""
    at = 0
    while at + _PREFIX <= len(data):
        opcode, length = data[at], int.from_bytes(data[at + 1 : at + _PREFIX], "little")
        start, at = at + _PREFIX, at + _PREFIX + length
        if at > len(data):
            return
        yield opcode, data[start:at]


def _stream(body: memoryview) -> ReadDataStream:
    return ReadDataStream(BytesIO(body))


def event_at(chunk: npt.NDArray[np.uint8], place: int) -> Event:
    """The event whose message record starts at a place of a chunk."""
    length = int.from_bytes(chunk[place + 1 : place + _PREFIX].tobytes(), "little")
    return Event.read(chunk[place + _RECORD : place + _PREFIX + length].tobytes())


class _Definitions:
    """The channels of a log; those that hold samples."""

    def __init__(self) -> None:
        #: The channel of events.
        self.events: int | None = None
        self.schemas: dict[int, list[Field] | None] = {}
        self.collectors: dict[int, _Collector] = {}

    def look_into(self, chunk: npt.NDArray[np.uint8]) -> None:
        """Takes the definitions in front of the messages of a chunk."""
        for opcode, body in _records(chunk.data):
            if opcode == Opcode.MESSAGE:
                return
            self.take(opcode, body)

    def take(self, opcode: int, body: memoryview) -> None:
        """Takes a record, if it defines something."""
        match opcode:
            case Opcode.SCHEMA:
                schema = Schema.read(_stream(body))
                self.schemas[schema.id] = fields_of(schema)
            case Opcode.CHANNEL:
                channel = Channel.read(_stream(body))
                if channel.topic == _EVENTS:
                    self.events = channel.id
                fields = self.schemas.get(channel.schema_id)
                if fields is not None and channel.id not in self.collectors:
                    self.collectors[channel.id] = _Collector(channel.topic, fields)


def _unpack(chunk: Chunk) -> npt.NDArray[np.uint8]:
    match chunk.compression:
        case "zstd":
            data = zstandard.decompress(chunk.data, chunk.uncompressed_size)
        case "lz4":
            data = lz4.frame.decompress(chunk.data)
        case _:
            data = chunk.data
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise ValueError("its checksum is wrong")
    return np.frombuffer(data, np.uint8)
