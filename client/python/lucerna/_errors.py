"""What the package raises."""
from __future__ import annotations

import dataclasses
import re
from typing import Any

import grpc

from lucerna import _wire


# As in proto/common/plain_text.cpp: control characters, line separators, and those that turn text about.
_OBEYED = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def _plain(text: str) -> str:
    """Text that a terminal shows and does not obey: servers may put escape sequences into errors."""
    return _OBEYED.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


@dataclasses.dataclass(frozen=True)
class FieldViolation:
    """A wrong field of a request."""

    field: str  #: its name in the contract, such as "receivers.offsets_m", or the name of an argument
    description: str  #: what is wrong, and what is allowed


class Error(Exception):
    """A call failed.  The subclasses name the codes that callers often handle.

    The message names the field, the value and what is allowed.  In all texts control characters are escaped.
    """

    code: grpc.StatusCode  #: the code of gRPC
    reason: str  #: for programs, such as "SCENE_NOT_LOADED" (docs/api.md lists them); empty if the server sent none
    violations: tuple[FieldViolation, ...]  #: the wrong fields of the request
    retry_after_s: float | None  #: when another attempt may succeed [s]; None if the server states no time
    request_id: str  #: as in the server's log; empty if no server answered

    def __init__(self, message: str, *, code: grpc.StatusCode = grpc.StatusCode.UNKNOWN, reason: str = "",
                 violations: tuple[FieldViolation, ...] = (), retry_after_s: float | None = None,
                 request_id: str = "") -> None:
        self.message = _plain(message)
        super().__init__(self.message)
        self.code = code
        self.reason = _plain(reason)
        self.violations = tuple(FieldViolation(_plain(v.field), _plain(v.description)) for v in violations)
        self.retry_after_s = retry_after_s
        self.request_id = _plain(request_id)

    def __str__(self) -> str:
        return self.message


class InvalidArgument(Error, ValueError):
    """A field of the request is wrong; `violations` name it.  The package checks shapes before it sends a request."""


class NotFound(Error, LookupError):
    """There is no such scene, light, file or lease."""


class FailedPrecondition(Error):
    """The state forbids the call.  For example, the scene to release is leased."""


class ResourceExhausted(Error):
    """The request exceeds a limit or a quota, or the server is busy.  `reason` names the cause.  `retry_after_s` is
    set if a later attempt may succeed."""


class Unavailable(Error, ConnectionError):
    """No server answers, or it is shutting down."""


class DeadlineExceeded(Error, TimeoutError):
    """The time-out passed before the answer was complete."""


class PermissionDenied(Error, PermissionError):
    """The token does not allow this call."""


class Unauthenticated(Error):
    """The call has no token, or the server does not know it."""


_CLASSES: dict[grpc.StatusCode, type[Error]] = {
    grpc.StatusCode.INVALID_ARGUMENT: InvalidArgument,
    grpc.StatusCode.NOT_FOUND: NotFound,
    grpc.StatusCode.FAILED_PRECONDITION: FailedPrecondition,
    grpc.StatusCode.RESOURCE_EXHAUSTED: ResourceExhausted,
    grpc.StatusCode.UNAVAILABLE: Unavailable,
    grpc.StatusCode.DEADLINE_EXCEEDED: DeadlineExceeded,
    grpc.StatusCode.PERMISSION_DENIED: PermissionDenied,
    grpc.StatusCode.UNAUTHENTICATED: Unauthenticated,
}


class _Shape:
    """Names and numbers of the fields of a message.  Stands for a descriptor in _wire.Answer."""

    def __init__(self, full_name: str, **fields: tuple[int, "_Shape" | None]) -> None:
        self.full_name = full_name
        self.fields_by_name = {name: _Field(*field) for name, field in fields.items()}


@dataclasses.dataclass(frozen=True)
class _Field:
    number: int
    message_type: _Shape | None = None


# The standard messages of google.rpc.  Their generated modules would clash with those of other packages.
_ANY = _Shape("google.protobuf.Any", type_url=(1, None), value=(2, None))
_STATUS = _Shape("google.rpc.Status", code=(1, None), message=(2, None), details=(3, _ANY))
_ERROR_INFO = _Shape("google.rpc.ErrorInfo", reason=(1, None), domain=(2, None))
_VIOLATION = _Shape("google.rpc.BadRequest.FieldViolation", field=(1, None), description=(2, None))
_BAD_REQUEST = _Shape("google.rpc.BadRequest", field_violations=(1, _VIOLATION))
_DURATION = _Shape("google.protobuf.Duration", seconds=(1, None), nanos=(2, None))
_RETRY_INFO = _Shape("google.rpc.RetryInfo", retry_delay=(1, _DURATION))


def _text(answer: _wire.Answer, name: str) -> str:
    return answer.data(name).decode("utf-8", "replace")


def invalid(field: str, description: str) -> InvalidArgument:
    """The error of a wrong argument that the package itself finds."""
    return InvalidArgument(f"{field}: {description}", code=grpc.StatusCode.INVALID_ARGUMENT, reason="BAD_FIELD",
                           violations=(FieldViolation(field, description),))


def broken(what: str) -> Error:
    """The error of an answer that does not fit its request."""
    return Error(f"the server broke the protocol: {what}", code=grpc.StatusCode.INTERNAL)


def from_rpc(error: Any) -> Error:
    """The error of a failed call of gRPC."""
    message = error.details() or ""
    reason, retry_after_s = "", None
    violations: list[FieldViolation] = []
    trailers = {key: value for key, value in error.trailing_metadata() or ()}
    try:
        for detail in _wire.Answer(trailers.get("grpc-status-details-bin", b""), _STATUS).messages("details"):
            kind, value = _text(detail, "type_url").rpartition("/")[2], detail.data("value")
            if kind == "google.rpc.ErrorInfo":
                reason = _text(_wire.Answer(value, _ERROR_INFO), "reason")
            elif kind == "google.rpc.BadRequest":
                violations += [FieldViolation(_text(v, "field"), _text(v, "description"))
                               for v in _wire.Answer(value, _BAD_REQUEST).messages("field_violations")]
            elif kind == "google.rpc.RetryInfo":
                delay = _wire.Answer(value, _RETRY_INFO).message("retry_delay")
                retry_after_s = delay.number("seconds") + 1e-9 * delay.number("nanos")
    except ValueError:
        pass  # details that are no message explain nothing; code and message remain
    for violation in violations:
        if violation.field not in message or violation.description not in message:
            message += f"; {violation.field}: {violation.description}"
    kind_of_error = _CLASSES.get(error.code(), Error)
    failed = kind_of_error(message, code=error.code(), reason=reason, violations=tuple(violations),
                           retry_after_s=retry_after_s, request_id=str(trailers.get("x-request-id", "")))
    failed.__suppress_context__ = True  # a traceback would show gRPC's error, with the server's text as it came
    return failed
