"""Arrays in the wire form of Protocol Buffers, without a loop in Python.

Debian's protobuf moves numbers of a repeated field one by one between C++ and Python.  A packed field is just a tag, a
length and the numbers, so NumPy writes and reads its bytes directly.  Small fields go through the generated messages.
"""
from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from google.protobuf.message import DecodeError
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Doubles = NDArray[np.float64]
Ids = NDArray[np.uint64]
Bools = NDArray[np.bool_]
M = TypeVar("M")


class Broken(ValueError):
    """An answer that does not fit its request.  Transports turn it into an Error of the package."""


_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5


def varint(value: int) -> bytes:
    """A number from 0 to 2^64 - 1 as a varint."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def field(number: int, content: bytes) -> bytes:
    """A field of bytes: a message, a string or a packed array."""
    return varint(number << 3 | _BYTES) + varint(len(content)) + content


def packed(path: Sequence[int], values: Floats | Doubles, before: bytes = b"") -> list[bytes | memoryview]:
    """A packed array in nested messages, as pieces to join.  Large arrays are thus copied once.

    `path` has the field numbers from the outermost message to the array.  `before` holds further fields of the
    innermost message.  Parsers merge messages that occur again, so each array may have its own copy of the nesting.
    """
    pieces: list[bytes | memoryview] = [before]
    size = len(before)
    if values.size:
        content = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
        buffer: Any = content
        pieces += [varint(path[-1] << 3 | _BYTES) + varint(content.nbytes), memoryview(buffer).cast("B")]
        size += len(pieces[1]) + content.nbytes
    for number in reversed(path[:-1]):
        head = varint(number << 3 | _BYTES) + varint(size)
        pieces.insert(0, head)
        size += len(head)
    return pieces


def _read_varint(data: memoryview, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at += 1
        if byte < 0x80:
            return value, at
        shift += 7


def unpack_varints(data: bytes | memoryview) -> Ids:
    """The numbers of a packed array of varints."""
    octets = np.frombuffer(data, np.uint8)
    last = octets < 0x80
    if last.all():
        return octets.astype(np.uint64)
    ends = np.flatnonzero(last)
    starts = np.zeros_like(ends)
    starts[1:] = ends[:-1] + 1
    place = np.arange(octets.size) - np.repeat(starts, ends - starts + 1)
    shifted = (octets & 0x7F).astype(np.uint64) << (7 * place).astype(np.uint64)
    total: Ids = np.add.reduceat(shifted, starts)
    return total


class Answer:
    """The fields of one serialised message, by their names.  Arrays are views of its bytes.

    Raises Broken for bytes that are not a message.
    """

    def __init__(self, data: bytes | memoryview, descriptor: Any) -> None:
        self._numbers = descriptor.fields_by_name
        self._values: dict[int, list[Any]] = {}
        view, at = memoryview(data), 0
        try:
            while at < len(view):
                tag, at = _read_varint(view, at)
                value: Any
                kind = tag & 7
                if kind == _VARINT:
                    value, at = _read_varint(view, at)
                elif kind == _BYTES:
                    size, at = _read_varint(view, at)
                    if size > len(view) - at:
                        raise ValueError
                    value, at = view[at:at + size], at + size
                elif kind in (_FIXED32, _FIXED64):
                    size = 4 if kind == _FIXED32 else 8
                    value = struct.unpack_from("<f" if kind == _FIXED32 else "<d", view, at)[0]
                    at += size
                else:
                    raise ValueError
                self._values.setdefault(tag >> 3, []).append(value)
        except (IndexError, ValueError, struct.error):
            raise Broken(f"the answer is no {descriptor.full_name}: wrong field near byte {at}") from None

    def _all(self, name: str) -> list[Any]:
        return self._values.get(self._numbers[name].number, [])

    def has(self, name: str) -> bool:
        """Whether the field was sent."""
        return bool(self._all(name))

    def _array(self, name: str, dtype: str) -> NDArray[Any]:
        # Serialisers send one piece.  The format also allows several, and single numbers.
        try:
            pieces = [np.frombuffer(v, dtype) if isinstance(v, memoryview) else np.array([v], dtype)
                      for v in self._all(name)]
        except ValueError as error:
            raise Broken(f"{name}: {error}") from None
        return pieces[0] if len(pieces) == 1 else np.concatenate([np.empty(0, dtype), *pieces])

    def floats(self, name: str) -> Floats:
        """A repeated float; empty if it was not sent."""
        return self._array(name, "<f4")

    def doubles(self, name: str) -> Doubles:
        """A repeated double; empty if it was not sent."""
        return self._array(name, "<f8")

    def varints(self, name: str) -> Ids:
        """Repeated whole numbers of 0 and above; empty if they were not sent."""
        pieces = [unpack_varints(v) if isinstance(v, memoryview) else np.array([v], np.uint64)
                  for v in self._all(name)]
        return pieces[0] if len(pieces) == 1 else np.concatenate([np.empty(0, np.uint64), *pieces])

    def data(self, name: str) -> bytes:
        """A field of bytes; empty if it was not sent."""
        values = self._all(name)
        return bytes(values[-1]) if values else b""

    def bits(self, name: str, count: int) -> Bools:
        """The first `count` bits of an array of bits."""
        octets = np.frombuffer(self.data(name), np.uint8)
        if octets.size != (count + 7) // 8:
            raise Broken(f"{name} has {octets.size} bytes, expected {(count + 7) // 8}")
        return np.unpackbits(octets, count=count, bitorder="little").view(np.bool_)

    def number(self, name: str) -> int:
        """A whole number; 0 if it was not sent."""
        values = self._all(name)
        return int(values[-1]) if values else 0

    def texts(self, name: str) -> list[str]:
        """The strings of a repeated field."""
        return [bytes(v).decode() for v in self._all(name)]

    def messages(self, name: str) -> list[Answer]:
        """The messages of a repeated field."""
        return [Answer(v, self._numbers[name].message_type) for v in self._all(name)]

    def message(self, name: str) -> Answer:
        """A message; all its fields are unset if it was not sent."""
        return Answer(b"".join(self._all(name)), self._numbers[name].message_type)


def parsed(kind: type[M], data: Any) -> M:
    """A small message from its bytes, with finite numbers."""
    try:
        message: M = getattr(kind, "FromString")(data)
    except DecodeError as error:
        raise Broken(str(error)) from None
    _check_finite(message)
    return message


def _check_finite(message: Any) -> None:
    for field, value in message.ListFields():
        values = value if field.label == field.LABEL_REPEATED else (value,)
        if field.type == field.TYPE_MESSAGE:
            for inner in values:
                _check_finite(inner)
        elif field.type in (field.TYPE_DOUBLE, field.TYPE_FLOAT) and not all(map(math.isfinite, values)):
            raise Broken(f"{field.full_name} has a number that is not finite")


def joined(parts: Iterable[NDArray[Any]]) -> NDArray[Any]:
    """One array of its own memory from views of answers."""
    return np.concatenate(list(parts))
