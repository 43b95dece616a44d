"""Requests of any size in batches that the server accepts.  client/rpc/batches.h does the same in C++.

The answer has the bits of a single request, since each batch states its position in the whole set (Seed.first_item).
"""
from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

from lucerna import _wire
from lucerna._steps import Pipeline, Steps, Unary
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
        parts = [self.head]
        parts += [_wire.packed(a.path, a.rows[first:first + count], a.before) for a in self.arrays]
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


def server_limits() -> Steps[admin_pb2.Limits]:
    """The limits of the server."""
    data = yield Unary("AdminService/GetServerInfo", b"")
    return _wire.parsed(admin_pb2.GetServerInfoResponse, data).limits


def in_batches(request: BatchRequest, *, per_item: int, fixed: int = FIXED, weight: int = 1, whole: bool = False,
               progress: Progress = False, batch: int | None = None) -> Steps[Answered]:
    """Sends a request in batches, several at a time.

    `per_item` and `fixed` bound the bytes of the answer.  An item counts as `weight` items in the server's limit.
    `whole`: never divides the request.  `batch`: items of a batch, at most; the default asks the server.
    """
    report = _reporter(progress, request.items)
    size = max(1, request.items)
    if not whole and request.items > 1:
        # The longer of request and answer counts.
        once = fixed + len(request.head) + 128
        each = max(weight * per_item, request.bytes_of_an_item)
        limit_items, limit_bytes = ALWAYS_ITEMS, ALWAYS_BYTES
        if request.items * weight > ALWAYS_ITEMS or once + request.items * each > ALWAYS_BYTES:
            limits = yield from server_limits()
            limit_items = min(max(limits.max_batch_items, 1), GOOD_ITEMS)
            limit_bytes = limits.max_message_bytes
        if batch is not None:
            limit_items = batch
        size = max(1, min(limit_items // weight, (limit_bytes - once) // each))
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
