"""Requests of any size in batches that the server accepts.  client/library/batches.h does the same in C++.

The answer has the bits of a single request, since each batch states its position in the whole set (Seed.first_item).
"""
from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

from lucerna import _wire
from lucerna._errors import ResourceExhausted
from lucerna._steps import Pipeline, ServerInfo, Steps, Unary
from lucerna.v1 import admin_pb2, lighting_pb2

# Larger batches are not faster.
GOOD_ITEMS = 8192
# Every server accepts this many items and bytes in a message.
ALWAYS_ITEMS, ALWAYS_BYTES = 1024, 1 << 20

# Upper bounds of the bytes of an answer, as in proto/common/answer_size.cpp.  A bit counts as a byte.
FIXED = 512
BIT = STATUS = 1
FLOAT, DOUBLE, ID, COUNT = 4, 8, 10, 5
CHOICE = ID + DOUBLE

Progress = bool | Callable[[int, int], None]


@dataclasses.dataclass(frozen=True)
class ItemArray:
    """Numbers of each item, at a place in the request."""

    path: tuple[int, ...]  # field numbers, from the request to the array
    rows: _wire.Floats | _wire.Doubles  # shape (items, numbers of an item)
    before: bytes = b""  # further fields of the message that holds the array, in every batch


@dataclasses.dataclass(frozen=True)
class BatchRequest:
    """A request whose items can be divided."""

    method: str  # such as "LightingService/Le"
    items: int
    head: bytes  # the fields that hold for all items
    arrays: tuple[ItemArray, ...]
    seed: tuple[int, lighting_pb2.Seed] | None = None  # field number and seed of the first item
    count: int | None = None  # field number of the number of items, in requests without arrays of items

    def part(self, first: int, count: int) -> bytes:
        """The request for items [first, first + count)."""
        parts: list[bytes | memoryview] = [self.head]
        for array in self.arrays:
            parts += _wire.packed(array.path, array.rows[first:first + count], array.before)
        if self.seed is not None:
            field, seed = self.seed
            moved = lighting_pb2.Seed(seed=seed.seed, first_item=seed.first_item + first)
            parts.append(_wire.field(field, moved.SerializeToString()))
        if self.count is not None:
            parts.append(_wire.varint(self.count << 3) + _wire.varint(count))
        return b"".join(parts)

    @property
    def bytes_of_an_item(self) -> int:
        """Bytes that each item adds to the request."""
        return sum(a.rows.itemsize * a.rows.shape[1] for a in self.arrays)


@dataclasses.dataclass(frozen=True)
class Answered:
    """The serialised answers of all batches, and the number of items of each."""

    parts: list[bytes]
    counts: list[int]


def server_limits(again: bool = False) -> Steps[admin_pb2.Limits]:
    """The limits of the server.  A connection asks for them once, or `again`."""
    return _wire.parsed(admin_pb2.GetServerInfoResponse, (yield ServerInfo(again))).limits


def in_batches(request: BatchRequest, *, per_item: int, fixed: int = FIXED, weight: int = 1, whole: bool = False,
               progress: Progress = False) -> Steps[Answered]:
    """Sends a request in batches, several at a time.

    `per_item` and `fixed` bound the bytes of the answer.  An item counts as `weight` items in the server's limit.
    `whole`: never divides the request.
    """
    # The longer of request and answer counts.
    once = fixed + len(request.head) + 128
    each = max(weight * per_item, request.bytes_of_an_item)
    few = request.items * weight <= ALWAYS_ITEMS and once + request.items * each <= ALWAYS_BYTES
    if whole or few or request.items <= 1:
        return (yield from _send(request, max(1, request.items), progress))

    def size(limits: admin_pb2.Limits) -> int:
        good = min(max(limits.max_batch_items, 1), GOOD_ITEMS)
        return max(1, min(good // weight, (limits.max_message_bytes - once) // each))

    first = size((yield from server_limits()))
    try:
        return (yield from _send(request, first, progress))
    except ResourceExhausted as error:
        if error.reason != "OVER_LIMIT":
            raise
        # A server may get other limits while it runs.
        second = size((yield from server_limits(again=True)))
        if second >= first:
            raise
    return (yield from _send(request, second, progress))


def _send(request: BatchRequest, size: int, progress: Progress) -> Steps[Answered]:
    """Sends batches of `size` items."""
    report = _reporter(progress, request.items)
    counts = [min(size, request.items - first) for first in range(0, request.items, size)] or [0]
    try:
        if len(counts) == 1:
            parts = [(yield Unary(request.method, request.part(0, request.items)))]
            report(request.items)
        else:
            finished = iter(counts)
            parts = yield Pipeline(request.method, _parts(request, size, counts), lambda: report(next(finished)))
    finally:
        report(-1)
    return Answered(parts, counts)


def _parts(request: BatchRequest, size: int, counts: list[int]) -> Iterator[bytes]:
    for index, count in enumerate(counts):
        yield request.part(index * size, count)


def _reporter(progress: Progress, total: int) -> Callable[[int], None]:
    """Reports finished items; -1 ends the report."""
    done = 0
    bar: Any = None
    if progress is True:
        try:
            from tqdm import tqdm  # only on request; Debian's python3-tqdm
        except ImportError:
            return lambda count: None
        bar = tqdm(total=total, unit=" items", unit_scale=True)

    def report(count: int) -> None:
        nonlocal done
        if count >= 0:
            done += count
        if bar is not None:
            bar.close() if count < 0 else bar.update(count)
        elif callable(progress) and count >= 0:
            progress(done, total)

    return report
