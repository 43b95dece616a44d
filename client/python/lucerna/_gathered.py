"""What the calls of LightingService share: fields of requests, and answers joined from batches."""
from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lucerna import _batches as b
from lucerna import _points as p
from lucerna import _results as results
from lucerna import _wire
from lucerna._errors import invalid
from lucerna.v1 import accuracy_pb2, lighting_pb2

Light = int | str


class SceneLike(Protocol):
    """What these functions need of a scene."""

    @property
    def id(self) -> str:
        """64 hexadecimal digits."""


def add_cost(cost: accuracy_pb2.Cost, whole: accuracy_pb2.Cost) -> None:
    """Adds all counts and times."""
    for field, value in cost.ListFields():
        setattr(whole, field.name, getattr(whole, field.name) + value)


def number_of(message: Any, field: str) -> int:
    """The number of a field of a message or of its class."""
    return int(message.DESCRIPTOR.fields_by_name[field].number)


def set_fields(message: Any, **fields: Any) -> None:
    """Sets the fields that are not None."""
    for name, value in fields.items():
        if value is None:
            continue
        try:
            if isinstance(value, (list, tuple, np.ndarray)):
                getattr(message, name).extend(np.asarray(value, np.float64).tolist())
            else:
                setattr(message, name, value)
        except (TypeError, ValueError) as error:
            raise invalid(name, str(error)) from None


def name_light(message: Any, light: Light | None) -> None:
    """Sets the light of a request, by its id or by its name."""
    if isinstance(light, str):
        message.light_name = light
    elif light is not None:
        set_fields(message, light_id=int(light))


def seed_of(seed: int, first_item: int) -> lighting_pb2.Seed:
    """The message of a seed."""
    message = lighting_pb2.Seed()
    set_fields(message, seed=seed, first_item=first_item)
    return message


def points_at(path: tuple[int, ...], points: NDArray[np.float64],
              origin: NDArray[np.float64] | None = None) -> b.ItemArray:
    """Points as offsets from `origin`, by default that of origin_of."""
    before, rows = p.offsets(points, p.origin_of(points) if origin is None else origin)
    return b.ItemArray((*path, p.OFFSETS), rows, before)


def next_page(request: Any, page: Any, entries: Any) -> bool:
    """Sets the token of the next page; False after the last one."""
    if page.next_page_token and (not entries or page.next_page_token == request.page_token):
        raise _wire.Broken(f"{type(page).__name__}.next_page_token: the list has no end")
    request.page_token = page.next_page_token
    return bool(request.page_token)


class Gathered:
    """The answers of all batches, with arrays joined and in the shape of the items."""

    def __init__(self, answered: b.Answered, message: Any, counts: Callable[[_wire.Answer, int], int] | None = None):
        self._parts = [_wire.Answer(data, message.DESCRIPTOR) for data in answered.parts]
        self._items = answered.counts
        self._counts = [counts(a, n) if counts else n for a, n in zip(self._parts, self._items)]

    @property
    def parts(self) -> list[_wire.Answer]:
        """The answers, batch by batch."""
        return self._parts

    def inside(self, name: str) -> Gathered:
        """The same for a message in each answer, which has arrays with an entry for each item."""
        inner = object.__new__(Gathered)
        inner._parts = [a.message(name) for a in self._parts]
        inner._items = inner._counts = self._items
        return inner

    @property
    def count(self) -> int:
        """Items in all batches."""
        return sum(self._counts)

    def floats(self, name: str, *shape: int) -> _wire.Floats:
        """A repeated float, in this shape."""
        return self.of_items(name, [a.floats(name) for a in self._parts], shape)

    def floats_if_any(self, name: str, *shape: int) -> _wire.Floats | None:
        """The same; None if no batch has numbers."""
        return self.floats(name, *shape) if any(a.has(name) for a in self._parts) else None

    def doubles_if_any(self, name: str, *shape: int) -> _wire.Doubles | None:
        """A repeated double, in this shape; None if no batch has numbers."""
        if not any(a.has(name) for a in self._parts):
            return None
        return self.of_items(name, [a.doubles(name) for a in self._parts], shape)

    def varints(self, name: str, *shape: int) -> _wire.Ids:
        """Repeated whole numbers, in this shape."""
        return self.of_items(name, [a.varints(name) for a in self._parts], shape)

    def varints_if_any(self, name: str, *shape: int) -> _wire.Ids | None:
        """The same; None if no batch has numbers."""
        return self.varints(name, *shape) if any(a.has(name) for a in self._parts) else None

    def bits(self, name: str, *shape: int) -> _wire.Bools:
        """An array of bits, in this shape."""
        bits = [a.bits(name, n) for a, n in zip(self._parts, self._counts)]
        return self.of_items(name, bits, shape)

    def bits_if_any(self, name: str, *shape: int) -> _wire.Bools | None:
        """The same; None if no batch has bits."""
        return self.bits(name, *shape) if any(a.has(name) for a in self._parts) else None

    def status(self, *shape: int) -> results.Statuses:
        """Statuses, in this shape.  An empty array of a batch means that all its items are OK."""
        if not any(a.has("status") for a in self._parts):
            return np.full(shape, results.OK, np.uint8)
        pieces = [a.varints("status").astype(np.uint8) if a.has("status") else np.full(n, results.OK, np.uint8)
                  for a, n in zip(self._parts, self._counts)]
        return self.of_items("status", pieces, shape)

    def of_items(self, name: str, parts: list[NDArray[Any]], shape: tuple[int, ...]) -> NDArray[Any]:
        """One array, in this shape, of those of the batches, after their checks."""
        # Each batch must have its own items: a longer one would hide that another one is too short.
        each = math.prod(shape) // max(self.count, 1)
        for part, n in zip(parts, self._counts):
            if part.size != n * each:
                raise _wire.Broken(f"{name} has {part.size} entries, expected {n * each}")
            if part.dtype.kind == "f" and not np.isfinite(part).all():
                raise _wire.Broken(f"{name} has a number that is not finite")
        try:
            return _wire.joined(parts).reshape(shape)
        except ValueError:
            count = sum(part.size for part in parts)
            raise _wire.Broken(f"{name} has {count} entries, expected shape {shape}") from None

    def cost(self) -> accuracy_pb2.Cost:
        """The sum of all counts and times."""
        whole = accuracy_pb2.Cost()
        for part in self._parts:
            add_cost(_wire.parsed(accuracy_pb2.Cost, part.data("cost")), whole)
        return whole
