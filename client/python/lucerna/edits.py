"""Edits of lights, for Scene.edit and Server.load.

    dimmed = scene.edit(lucerna.edits.change("Desk lamp", scale=0.5), lucerna.edits.remove(7))
"""
from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from numpy.typing import ArrayLike

from lucerna._errors import NotFound, invalid
from lucerna._points import vectors
from lucerna.v1 import accuracy_pb2, light_pb2, scene_pb2

__all__ = ["Edit", "add", "change", "put", "remove"]


@dataclasses.dataclass(frozen=True)
class Edit:
    """One edit.  The functions of this module make it.  A name means every light with this name."""

    message: scene_pb2.LightEdit  #: of the contract; with a name, its light is set later
    light: int | str | None = None  #: the light that it changes or removes


def change(light: int | str, *, scale: float | None = None, tint: ArrayLike | None = None, on: bool | None = None,
           shift: ArrayLike | None = None, turn_axis: ArrayLike | None = None, turn_rad: float = 0.0) -> Edit:
    """Changes a light, compared with the light in its file.

    light: id or name.  scale: factor of the level, in [0, 1e9].  tint: factors of R, G and B.  on: False is dark.
    shift: world [m], shape (3,).  turn_axis, turn_rad: a turn about the light's own position [rad], counter-clockwise
    seen against the axis.  Errors: InvalidArgument for other shapes; the server checks the numbers.
    """
    message = scene_pb2.LightEdit()
    message.change.SetInParent()
    if scale is not None:
        message.change.scale = scale
    if tint is not None:
        r, g, b = _three("tint", tint)
        message.change.tint.CopyFrom(accuracy_pb2.Rgb(r=r, g=g, b=b))
    if on is not None:
        message.change.on = on
    if shift is not None or turn_axis is not None:
        message.change.placement.SetInParent()
        if shift is not None:
            message.change.placement.shift_m.CopyFrom(_vector("shift", shift))
        if turn_axis is not None:
            message.change.placement.turn_axis.CopyFrom(_vector("turn_axis", turn_axis))
            message.change.placement.turn_rad = turn_rad
    return Edit(message, light)


def remove(light: int | str) -> Edit:
    """Removes a light, by its id or name.  If it has a surface, the surface stays and is dark."""
    return Edit(scene_pb2.LightEdit(), light)


def put(light: light_pb2.Light) -> Edit:
    """Replaces the light with this id; id 0 makes a new light.

    The light must be a point, spot, distant, sun or uniform infinite light.
    """
    return Edit(scene_pb2.LightEdit(put=light))


def add(path: str) -> Edit:
    """Adds the lights of another scene file under the scene root."""
    return Edit(scene_pb2.LightEdit(add=scene_pb2.LightFile(path=path)))


def _three(name: str, values: ArrayLike) -> tuple[float, float, float]:
    array = vectors(name, values)
    if array.shape != (3,):
        raise invalid(name, f"has shape {array.shape}, must be (3,)")
    return float(array[0]), float(array[1]), float(array[2])


def _vector(name: str, values: ArrayLike) -> accuracy_pb2.Vector3:
    x, y, z = _three(name, values)
    return accuracy_pb2.Vector3(x=x, y=y, z=z)


def resolved(edits: Sequence[Edit], names: Mapping[str, Sequence[int]]) -> list[scene_pb2.LightEdit]:
    """The messages, with ids of lights in place of their names.  NotFound for a name that no light has."""
    messages = []
    for edit in edits:
        ids: Sequence[int] = ()
        if isinstance(edit.light, str):
            if not edit.light or edit.light not in names:
                raise NotFound(f'the scene has no light named "{edit.light}"')
            ids = names[edit.light]
        elif edit.light is not None:
            ids = (edit.light,)
        for light in ids:
            message = scene_pb2.LightEdit()
            message.CopyFrom(edit.message)
            if message.HasField("change"):
                message.change.light_id = light
            else:
                message.remove = light
            messages.append(message)
        if edit.light is None:
            messages.append(edit.message)
    return messages
