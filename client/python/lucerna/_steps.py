"""Calls as sequences of steps, so that blocking and asyncio clients share everything but the waiting.

A method of the package is a generator.  It yields steps, receives their results, and returns its answer.  `Transport`
takes the steps one after the other and blocks; `lucerna.aio` has a transport that awaits them.
"""
from __future__ import annotations

import collections
import dataclasses
import functools
import inspect
import time
from collections.abc import Callable, Generator, Iterator
from typing import Any, Concatenate, ParamSpec, TypeVar

import grpc

from lucerna import _errors, _wire
from lucerna._channel import Connection


@dataclasses.dataclass(frozen=True)
class Unary:
    """One call; the result is the serialised response."""

    method: str
    request: bytes


@dataclasses.dataclass(frozen=True)
class Pipeline:
    """Several calls of one method, some of them in flight at a time; the result is the list of responses."""

    method: str
    requests: Iterator[bytes]
    done: Callable[[], None]  # after each response, in the order of the requests


@dataclasses.dataclass(frozen=True)
class Upload:
    """One call with a stream of requests; the result is the serialised response."""

    method: str
    requests: Iterator[bytes]


@dataclasses.dataclass(frozen=True)
class Stream:
    """One call with a stream of responses; the result is None."""

    method: str
    request: bytes
    receive: Callable[[bytes], None]


@dataclasses.dataclass(frozen=True)
class Work:
    """Work on files or numbers that takes long; the result is that of the function."""

    run: Callable[[], Any]


@dataclasses.dataclass(frozen=True)
class Pause:
    """Waits [s]."""

    seconds: float


@dataclasses.dataclass(frozen=True)
class ServerInfo:
    """The serialised response of GetServerInfo, which a connection keeps.  `again`: asks the server again."""

    again: bool


R = TypeVar("R")
P = ParamSpec("P")
Step = Unary | Pipeline | Upload | Stream | Work | Pause | ServerInfo
Steps = Generator[Step, Any, R]


INFO = Unary("AdminService/GetServerInfo", b"")


def path_of(method: str) -> str:
    """The path of a method such as "LightingService/Le"."""
    return f"/lucerna.v1.{method}"


class Transport:
    """A blocking connection.  Any number of threads may use it at once."""

    def __init__(self, connection: Connection, in_flight: int) -> None:
        self.connection = connection
        self.in_flight = in_flight
        self._info: bytes | None = None
        credentials, options = connection.credentials(), connection.options()
        self._channel = (grpc.secure_channel(connection.target, credentials, options) if credentials
                         else grpc.insecure_channel(connection.target, options))

    def close(self) -> None:
        """Closes the connection; running calls end with CANCELLED."""
        self._channel.close()

    def run(self, steps: Steps[R], timeout_s: float | None) -> R:
        """Takes all steps.  The time-out is for all of them together."""
        end = None if timeout_s is None else time.monotonic() + timeout_s
        try:
            step = next(steps)
            while True:
                try:
                    result = self._take(step, end)
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

    def _take(self, step: Step, end: float | None) -> Any:
        left = None if end is None else max(0.0, end - time.monotonic())
        metadata = self.connection.metadata
        if isinstance(step, Unary):
            return self._channel.unary_unary(path_of(step.method))(step.request, timeout=left, metadata=metadata)
        if isinstance(step, Pipeline):
            return self._pipeline(step, left)
        if isinstance(step, Upload):
            return self._channel.stream_unary(path_of(step.method))(step.requests, timeout=left, metadata=metadata)
        if isinstance(step, Stream):
            call = self._channel.unary_stream(path_of(step.method))(step.request, timeout=left, metadata=metadata)
            try:
                for message in call:
                    step.receive(message)
            finally:
                call.cancel()
            return None
        if isinstance(step, ServerInfo):
            if self._info is None or step.again:
                self._info = self._take(INFO, end)
            return self._info
        if isinstance(step, Work):
            return step.run()
        time.sleep(step.seconds if left is None else min(step.seconds, left))
        return None

    def _pipeline(self, step: Pipeline, left: float | None) -> list[bytes]:
        start = self._channel.unary_unary(path_of(step.method)).future
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
                answers.append(running[0].result())
                running.popleft()
                step.done()
        finally:
            for call in running:
                call.cancel()
        return answers


class Caller:
    """What can take steps: a server or a scene of the blocking client."""

    _transport: Transport
    _timeout_s: float | None

    def _run(self, steps: Steps[R]) -> R:
        return self._transport.run(steps, self._timeout_s)


def blocking(function: Callable[Concatenate[Any, P], Steps[R]]) -> Callable[Concatenate[Any, P], R]:
    """The blocking method of a generator, for classes that are a Caller."""

    @functools.wraps(function)
    def method(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> R:
        caller: Caller = self
        return caller._run(function(self, *args, **kwargs))

    describe(method, function)
    return method


def describe(method: Any, function: Callable[..., Any]) -> None:
    """Gives a method the signature that help() shows: that of its steps, with the type of the answer."""
    signature = inspect.signature(function)
    answer = str(signature.return_annotation).removeprefix("Steps[").removesuffix("]")
    method.__signature__ = signature.replace(return_annotation=answer)
    method.__annotations__ = {**function.__annotations__, "return": answer}
