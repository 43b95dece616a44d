"""The blocking client."""
from __future__ import annotations

import copy
import os
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

from lucerna import _channel, _lighting, _pictures, _sampling, _scenes
from lucerna.edits import Edit
from lucerna._errors import invalid
from lucerna._gathered import set_fields
from lucerna._steps import Caller, Transport, blocking
from lucerna.v1 import scene_pb2

Path = str | os.PathLike[str]


def load_request(lease_s: float | None, blender: str | None, lumens_per_watt: float | None,
                 path: Path | None = None) -> scene_pb2.LoadSceneRequest:
    """The request of load and upload; without a path the manifest is set later."""
    request = scene_pb2.LoadSceneRequest(blender=_scenes.blender_levels(blender, lumens_per_watt))
    if path is not None:
        request.path = os.fspath(path)
    set_fields(request, lease_s=lease_s)
    return request


def check_timeout(seconds: float | None) -> float | None:
    """The time-out itself.  InvalidArgument for one that is not above 0."""
    if seconds is not None and not seconds > 0:
        raise invalid("timeout", f"is {seconds}, allowed: above 0 s")
    # The clocks of gRPC and of Python end; more than thirty years are no limit.
    return None if seconds is None or seconds > 1e9 else seconds


class Scene(Caller):
    """A scene that a server has loaded.  `Server.load` and `Server.upload` make one.

    Any number of threads may use it at once.
    """

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
        return f"<lucerna.Scene {self.id[:12]} on {self._transport.connection.target}>"

    def within(self, seconds: float | None) -> Self:
        """The same scene with a time-out for each method [s], above 0; None: no time-out."""
        other = copy.copy(self)
        other._timeout_s = check_timeout(seconds)
        return other

    irradiance = blocking(_lighting.irradiance)
    sample_li = blocking(_sampling.sample_li)
    pdf_li = blocking(_sampling.pdf_li)
    sample_le = blocking(_sampling.sample_le)
    pdf_le = blocking(_sampling.pdf_le)
    le = blocking(_lighting.le)
    visible = blocking(_lighting.visible)
    find_surfaces = blocking(_lighting.find_surfaces)
    power = blocking(_lighting.power)
    lights = blocking(_scenes.lights)
    description = blocking(_scenes.description)
    tile = blocking(_pictures.tile)
    render = blocking(_pictures.render)
    renew = blocking(_scenes.renew)
    release = blocking(_scenes.release)

    def edit(self, *edits: Edit, lease_s: float | None = None) -> Scene:
        """Makes a revision of the scene with other lights.  This scene stays as it is.

        edits: of `lucerna.edits`, in order.  lease_s: the server keeps the revision at least this long [s].  Errors:
        NotFound for a light that the scene does not have, InvalidArgument for an edit that its light does not allow.
        """
        return Scene(self._server, self._run(_scenes.edit(self, edits, lease_s)))


class Server(Caller):
    """A connection to a lucernad.  `lucerna.connect` makes one; leaving its `with` block closes it.

    Any number of threads may use it at once.  Do not use it in a child after os.fork().
    """

    def __init__(self, transport: Transport, timeout_s: float | None) -> None:
        self._transport = transport
        self._timeout_s = timeout_s

    def __repr__(self) -> str:
        return f"<lucerna.Server {self.target}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    @property
    def target(self) -> str:
        """HOST:PORT, or what `connect` got."""
        return self._transport.connection.target

    def close(self) -> None:
        """Closes the connection.  Its scenes can no longer be used; the server keeps them."""
        self._transport.close()

    def within(self, seconds: float | None) -> Self:
        """The same server with a time-out for each method [s], above 0; None: no time-out.  Its scenes inherit it."""
        other = copy.copy(self)
        other._timeout_s = check_timeout(seconds)
        return other

    info = blocking(_scenes.info)
    stats = blocking(_scenes.stats)
    scenes = blocking(_scenes.scenes)
    available = blocking(_scenes.available)
    leases = blocking(_scenes.leases)

    def load(self, path: Path, *, lease_s: float | None = None, edits: Sequence[Edit] = (),
             blender: str | None = None, lumens_per_watt: float | None = None) -> Scene:
        """Loads a scene file under the server's scene root.

        path: relative to the scene root.  lease_s: the server keeps the scene at least this long [s].  edits: the scene
        is loaded with these edits of its lights.  blender: the lighting mode of a glTF file from Blender ("standard",
        "unitless", "raw").  lumens_per_watt: of Blender's watts [lm/W].  Errors: NotFound for a file that does not
        exist, InvalidArgument with file:line:column for one that cannot be read, ResourceExhausted.
        """
        request = load_request(None if edits else lease_s, blender, lumens_per_watt, path)
        scene = Scene(self, self._run(_scenes.load(request)))
        return scene.edit(*edits, lease_s=lease_s) if edits else scene

    def upload(self, path: Path, *, root: Path | None = None, lease_s: float | None = None,
               blender: str | None = None, lumens_per_watt: float | None = None,
               progress: _scenes.UploadProgress | None = None) -> Scene:
        """Loads a scene file of this machine, with all files that it names.

        Only files that the server does not have are sent.  root: only files in this folder are sent; by default the
        folder of the scene file.  progress: is called with the name, the sent bytes and the bytes of a file.  The rest,
        and errors: as in `load`; InvalidArgument for a file outside the root.
        """
        request = load_request(lease_s, blender, lumens_per_watt)
        return Scene(self, self._run(_scenes.upload(path, root, request, progress)))

    def scene(self, scene_id: str, lease_id: str = "") -> Scene:
        """A loaded scene by its id, without a call.  `lease_id`: the lease that `release` ends."""
        return Scene(self, _scenes.Loaded(id=scene_id, lease_id=lease_id))


def connect(target: str | None = None, *, token: str | None = None, token_file: Path | None = None,
            tls: bool | None = None, ca: Path | None = None, certificate: Path | None = None, key: Path | None = None,
            name: str | None = None, timeout: float | None = None, in_flight: int = 4) -> Server:
    """Connects to a server.  Nothing is sent yet.

    Arguments that are None come from the environment, with the variables of the command line (docs/security.md).
    target: HOST:PORT, from LUCERNA_SERVER, or 127.0.0.1:50051.  token, token_file: the token of the caller, or a file
    with it.  tls: encrypts; so does each of ca, certificate, key and name.  ca: PEM file with the authorities that may
    sign the server's certificate; default those of this machine.  certificate, key: PEM files of a client certificate.
    name: the name that the server's certificate must have.  timeout: for each method [s], default none.  in_flight:
    batches of one method that are sent before the first is answered, at least 1.

    After UNAVAILABLE a call is retried up to four times within half a second.  Errors: InvalidArgument for a
    target without a host or with a port outside of 1 to 65535, for a file that cannot be read, and for a token that
    would leave this machine without TLS.
    """
    connection = _channel.settings(target, token=token, token_file=token_file, tls=tls, ca=ca, certificate=certificate,
                                   key=key, name=name)
    return Server(Transport(connection, check_in_flight(in_flight)), check_timeout(timeout))


def check_in_flight(count: Any) -> int:
    """The count itself.  InvalidArgument for one that is no whole number above 0."""
    if not isinstance(count, int) or count < 1:
        raise invalid("in_flight", f"is {count!r}, allowed: 1 and above")
    return count
