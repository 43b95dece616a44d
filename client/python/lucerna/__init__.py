"""Lucerna in Python: ask a lighting-query server about the light in a scene.

    import lucerna
    scene = lucerna.connect().load("room/scene.pbrt")
    desk = lucerna.grid((0.5, 0.5, 0.8), (5, 0, 0), (0, 3, 0), columns=50, rows=30)
    answer = scene.irradiance(desk, error=0.05)
    answer.plot("map.png")

Points and directions are arrays of shape (..., 3): a list of points, or a grid of them.  Answers have the same leading
shape.  Lengths are in metres, angles in radians, times in seconds, RGB is linear (Rec. 709, D65).  docs/python.md shows
everything.  `lucerna.aio` has the same client for asyncio, `lucerna.v1` the generated messages.
"""
from lucerna import aio, edits
from lucerna._accuracy import Accuracy
from lucerna._client import Scene, Server, connect
from lucerna._errors import (DeadlineExceeded, Error, FailedPrecondition, FieldViolation, InvalidArgument, NotFound,
                             PermissionDenied, ResourceExhausted, Unauthenticated, Unavailable)
from lucerna._local import LocalServer, local
from lucerna._pictures import Picture, Tile
from lucerna._points import Grid, grid
from lucerna._results import (STATUS, EmissionDensity, EmissionSamples, Estimates, Irradiance, LightDensity,
                              LightSamples, Power, Radiance, Shares, Surfaces, Visibility)
from lucerna._scenes import Lights

__all__ = [
    "STATUS", "Accuracy", "DeadlineExceeded", "EmissionDensity", "EmissionSamples", "Error", "Estimates",
    "FailedPrecondition", "FieldViolation", "Grid", "InvalidArgument", "Irradiance", "LightDensity", "LightSamples",
    "Lights", "LocalServer", "NotFound", "PermissionDenied", "Picture", "Power", "Radiance", "ResourceExhausted",
    "Scene", "Server", "Shares", "Surfaces", "Tile", "Unauthenticated", "Unavailable", "Visibility", "aio", "connect",
    "edits", "grid", "local",
]
__version__ = "0.1.0"
