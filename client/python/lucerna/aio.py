"""The client for asyncio: the methods of `lucerna.Server` and `lucerna.Scene` as coroutines.

    async with lucerna.aio.connect("127.0.0.1:50051") as server:
        scene = await server.load("room/scene.pbrt")
        a, b = await asyncio.gather(scene.irradiance(here, up), scene.irradiance(there, up))

Cancelling a task cancels its calls.
"""
from __future__ import annotations

import asyncio
import collections
import copy
import functools
import os
import time
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from types import TracebackType
from typing import Any, Concatenate, ParamSpec, Self, TypeVar

import grpc

from lucerna import _channel, _errors, _lighting, _pictures, _sampling, _scenes, _wire
from lucerna._client import check_in_flight, check_timeout, load_request
from lucerna.edits import Edit
from lucerna._steps import (INFO, Pause, Pipeline, ServerInfo, Step, Steps, Stream, Unary, Upload, Work, describe,
                            path_of)
from lucerna.v1 import scene_pb2

__all__ = ["Scene", "Server", "connect"]

Path = str | os.PathLike[str]
R = TypeVar("R")
P = ParamSpec("P")


class _Transport:
    """A connection of the event loop that runs when it is made."""

    def __init__(self, connection: _channel.Connection, in_flight: int) -> None:
        self.connection = connection
        self.in_flight = in_flight
        self._info: bytes | None = None
        credentials, options = connection.credentials(), connection.options()
        self._channel = (grpc.aio.secure_channel(connection.target, credentials, options) if credentials
                         else grpc.aio.insecure_channel(connection.target, options))

    async def close(self) -> None:
        await self._channel.close()

    async def run(self, steps: Steps[R], timeout_s: float | None) -> R:
        end = None if timeout_s is None else time.monotonic() + timeout_s
        try:
            step = next(steps)
            while True:
                try:
                    result = await self._take(step, end)
                except grpc.RpcError as error:
                    step = steps.throw(_errors.from_rpc(error))
                else:
                    step = steps.send(result)
        except StopIteration as finish:
            value: R = finish.value
            return value
        except _wire.Broken as error:
            raise _errors.broken(str(error)) from None
        finally:
            steps.close()

    async def _take(self, step: Step, end: float | None) -> Any:
        left = None if end is None else max(0.0, end - time.monotonic())
        metadata = self.connection.metadata
        if isinstance(step, Unary):
            return await self._channel.unary_unary(path_of(step.method))(step.request, timeout=left, metadata=metadata)
        if isinstance(step, Pipeline):
            return await self._pipeline(step, left)
        if isinstance(step, Upload):
            return await self._channel.stream_unary(path_of(step.method))(step.requests, timeout=left,
                                                                          metadata=metadata)
        if isinstance(step, Stream):
            call = self._channel.unary_stream(path_of(step.method))(step.request, timeout=left, metadata=metadata)
            try:
                async for message in call:
                    step.receive(message)
            finally:
                call.cancel()
            return None
        if isinstance(step, ServerInfo):
            if self._info is None or step.again:
                self._info = await self._take(INFO, end)
            return self._info
        if isinstance(step, Work):
            return await asyncio.to_thread(step.run)
        assert isinstance(step, Pause)
        await asyncio.sleep(step.seconds if left is None else min(step.seconds, left))
        return None

    async def _pipeline(self, step: Pipeline, left: float | None) -> list[bytes]:
        start = self._channel.unary_unary(path_of(step.method))
        answers: list[bytes] = []
        running: collections.deque[Any] = collections.deque()
        try:
            more = True
            while more or running:
                if more and len(running) < self.in_flight:
                    request = next(step.requests, None)
                    more = request is not None
                    if more:
                        running.append(start(request, timeout=left, metadata=self.connection.metadata))
                    continue
                answers.append(await running[0])
                running.popleft()
                step.done()
        finally:
            for call in running:
                call.cancel()
        return answers


class _Caller:
    _transport: _Transport
    _timeout_s: float | None

    def _run(self, steps: Steps[R]) -> Awaitable[R]:
        return self._transport.run(steps, self._timeout_s)


def _coroutine(
        function: Callable[Concatenate[Any, P], Steps[R]]) -> Callable[Concatenate[Any, P], Coroutine[Any, Any, R]]:
    """The coroutine of a generator."""

    @functools.wraps(function)
    async def method(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> R:
        caller: _Caller = self
        return await caller._run(function(self, *args, **kwargs))

    describe(method, function)
    return method


class Scene(_Caller):
    """As lucerna.Scene, with coroutines."""

    id: str  #: a digest of all its files, 64 hexadecimal digits
    lease_id: str  #: the lease that keeps it loaded; empty without `lease_s`
    remarks: tuple[scene_pb2.Remark, ...]  #: what is not modelled
    new_lights: tuple[int, ...]  #: ids of the lights that `edit` made

    def __init__(self, server: Server, loaded: _scenes.Loaded) -> None:
        self._transport = server._transport
        self._timeout_s = server._timeout_s
        self._server = server
        self.id, self.lease_id = loaded.id, loaded.lease_id
        self.remarks, self.new_lights = loaded.remarks, loaded.new_lights

    def __repr__(self) -> str:
        return f"<lucerna.aio.Scene {self.id[:12]} on {self._transport.connection.target}>"

    def within(self, seconds: float | None) -> Self:
        """The same scene with a time-out for each method [s], above 0; None: no time-out."""
        other = copy.copy(self)
        other._timeout_s = check_timeout(seconds)
        return other

    irradiance = _coroutine(_lighting.irradiance)
    sample_li = _coroutine(_sampling.sample_li)
    pdf_li = _coroutine(_sampling.pdf_li)
    sample_le = _coroutine(_sampling.sample_le)
    pdf_le = _coroutine(_sampling.pdf_le)
    le = _coroutine(_lighting.le)
    visible = _coroutine(_lighting.visible)
    find_surfaces = _coroutine(_lighting.find_surfaces)
    power = _coroutine(_lighting.power)
    lights = _coroutine(_scenes.lights)
    description = _coroutine(_scenes.description)
    tile = _coroutine(_pictures.tile)
    render = _coroutine(_pictures.render)
    renew = _coroutine(_scenes.renew)
    release = _coroutine(_scenes.release)

    async def edit(self, *edits: Edit, lease_s: float | None = None) -> Scene:
        """As lucerna.Scene.edit."""
        return Scene(self._server, await self._run(_scenes.edit(self, edits, lease_s)))


class Server(_Caller):
    """As lucerna.Server, with coroutines; leaving its `async with` block closes it."""

    def __init__(self, transport: _Transport, timeout_s: float | None) -> None:
        self._transport = transport
        self._timeout_s = timeout_s

    def __repr__(self) -> str:
        return f"<lucerna.aio.Server {self.target}>"

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None,
                        trace: TracebackType | None) -> None:
        await self.close()

    @property
    def target(self) -> str:
        """HOST:PORT, or what `connect` got."""
        return self._transport.connection.target

    async def close(self) -> None:
        """Closes the connection.  Its scenes can no longer be used; the server keeps them."""
        await self._transport.close()

    def within(self, seconds: float | None) -> Self:
        """The same server with a time-out for each method [s], above 0; None: no time-out.  Its scenes inherit it."""
        other = copy.copy(self)
        other._timeout_s = check_timeout(seconds)
        return other

    info = _coroutine(_scenes.info)
    stats = _coroutine(_scenes.stats)
    scenes = _coroutine(_scenes.scenes)
    available = _coroutine(_scenes.available)
    leases = _coroutine(_scenes.leases)

    async def load(self, path: Path, *, lease_s: float | None = None, edits: Sequence[Edit] = (),
                   blender: str | None = None, lumens_per_watt: float | None = None) -> Scene:
        """As lucerna.Server.load."""
        request = load_request(None if edits else lease_s, blender, lumens_per_watt, path)
        scene = Scene(self, await self._run(_scenes.load(request)))
        return await scene.edit(*edits, lease_s=lease_s) if edits else scene

    async def upload(self, path: Path, *, root: Path | None = None, lease_s: float | None = None,
                     blender: str | None = None, lumens_per_watt: float | None = None,
                     progress: _scenes.UploadProgress | None = None) -> Scene:
        """As lucerna.Server.upload."""
        request = load_request(lease_s, blender, lumens_per_watt)
        return Scene(self, await self._run(_scenes.upload(path, root, request, progress)))

    def scene(self, scene_id: str, lease_id: str = "") -> Scene:
        """A loaded scene by its id, without a call.  `lease_id`: the lease that `release` ends."""
        return Scene(self, _scenes.Loaded(id=scene_id, lease_id=lease_id))


def connect(target: str | None = None, *, token: str | None = None, token_file: Path | None = None,
            tls: bool | None = None, ca: Path | None = None, certificate: Path | None = None, key: Path | None = None,
            name: str | None = None, timeout: float | None = None, in_flight: int = 4) -> Server:
    """As lucerna.connect.  Call it where an event loop runs; the connection belongs to this loop."""
    connection = _channel.settings(target, token=token, token_file=token_file, tls=tls, ca=ca, certificate=certificate,
                                   key=key, name=name)
    return Server(_Transport(connection, check_in_flight(in_flight)), check_timeout(timeout))
