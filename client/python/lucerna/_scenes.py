"""The calls of SceneService and AdminService, as steps."""
from __future__ import annotations

import dataclasses
import hashlib
import os
import pathlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from lucerna import _results as results
from lucerna import _wire
from lucerna.edits import Edit, resolved
from lucerna._errors import FailedPrecondition, InvalidArgument, NotFound, Unavailable, invalid
from lucerna._gathered import SceneLike, next_page, set_fields
from lucerna._steps import INFO, Pause, Steps, Unary, Upload, Work
from lucerna._wire import Bools, Doubles, Ids
from lucerna.v1 import admin_pb2, light_pb2, scene_pb2

_CHUNK = 1 << 20
_TRIES = 5  # attempts in a row without progress
_ROUNDS = 100  # files may name further files; no real scene needs as many rounds


@dataclasses.dataclass(frozen=True, kw_only=True)
class Loaded:
    """A scene that the server has loaded, before it becomes a Scene."""

    id: str
    lease_id: str
    remarks: tuple[scene_pb2.Remark, ...] = ()
    new_lights: tuple[int, ...] = ()


@dataclasses.dataclass(frozen=True, kw_only=True)
class Lights:
    """The lights of a scene, from Scene.lights.  NaN stands for a number that the light does not have."""

    ids: Ids  #: shape (L,)
    names: tuple[str, ...]  #: empty for lights without a name
    kinds: tuple[str, ...]  #: such as "spot" or "diffuse_area"
    delta: Bools  #: shines from one point or from one direction, shape (L,)
    power: Doubles  #: luminous flux [lm], shape (L,)
    power_error: Doubles  #: bound on its error [lm], shape (L,)
    area: Doubles  #: of the surface, counting one side [m2], shape (L,)
    messages: tuple[light_pb2.Light, ...]  #: all that the server tells of each light (proto/lucerna/v1/light.proto)

    def __len__(self) -> int:
        return len(self.messages)

    def frame(self) -> Any:
        """A pandas DataFrame with a row for each light.  ImportError without pandas."""
        return results.frame_of(results.columns(
            light=self.ids, name=np.array(self.names, object), kind=np.array(self.kinds, object), delta=self.delta,
            flux_lm=self.power, error_lm=self.power_error, area_m2=self.area))


def info(_: Any) -> Steps[admin_pb2.GetServerInfoResponse]:
    """Returns version, limits, threads and numeric fingerprint of the server."""
    return _wire.parsed(admin_pb2.GetServerInfoResponse, (yield INFO))


def stats(_: Any) -> Steps[admin_pb2.GetStatsResponse]:
    """Returns counters, queues and memory of the server."""
    return _wire.parsed(admin_pb2.GetStatsResponse, (yield Unary("AdminService/GetStats", b"")))


def _pages(method: str, request: Any, response: Any, field: str) -> Steps[tuple[Any, ...]]:
    found: list[Any] = []
    while True:
        page = _wire.parsed(response, (yield Unary(method, request.SerializeToString())))
        found += getattr(page, field)
        if not next_page(request, page, getattr(page, field)):
            return tuple(found)


def scenes(_: Any) -> Steps[tuple[scene_pb2.SceneSummary, ...]]:
    """Lists the loaded scenes, in the order of their ids."""
    return (yield from _pages("SceneService/ListScenes", scene_pb2.ListScenesRequest(), scene_pb2.ListScenesResponse,
                              "scenes"))


def available(_: Any) -> Steps[tuple[str, ...]]:
    """Lists the scene files under the scene root, as `load` takes them."""
    return (yield from _pages("SceneService/ListAvailableScenes", scene_pb2.ListAvailableScenesRequest(),
                              scene_pb2.ListAvailableScenesResponse, "paths"))


def leases(_: Any) -> Steps[tuple[admin_pb2.SceneLease, ...]]:
    """Lists the leases of the caller; with the role admin, those of all."""
    return (yield from _pages("AdminService/ListLeases", admin_pb2.ListLeasesRequest(), admin_pb2.ListLeasesResponse,
                              "leases"))


def description(scene: SceneLike) -> Steps[scene_pb2.GetSceneResponse]:
    """Describes the scene: its summary, contents, remarks, files and memory."""
    request = scene_pb2.GetSceneRequest(scene_id=scene.id)
    data = yield Unary("SceneService/GetScene", request.SerializeToString())
    return _wire.parsed(scene_pb2.GetSceneResponse, data)


def lights(scene: SceneLike) -> Steps[Lights]:
    """Lists the lights of the scene, in the order of their ids."""
    found = yield from _pages("SceneService/ListLights", scene_pb2.ListLightsRequest(scene_id=scene.id),
                              scene_pb2.ListLightsResponse, "lights")
    return Lights(
        ids=np.array([x.id for x in found], np.uint64), names=tuple(x.name for x in found),
        kinds=tuple(x.WhichOneof("kind") or "" for x in found), delta=np.array([x.delta for x in found], np.bool_),
        power=np.array([x.power_lm for x in found], float),
        power_error=np.array([x.power_error_lm for x in found], float),
        area=np.array([x.area_m2 if x.HasField("area_m2") else np.nan for x in found], float), messages=found)


def blender_levels(mode: str | None, lumens_per_watt: float | None) -> scene_pb2.BlenderLevels | None:
    """The factors of files that Blender exported; None without a mode."""
    if mode is None:
        return None
    modes = scene_pb2.BlenderLightingMode.keys()
    name = f"BLENDER_LIGHTING_MODE_{mode.upper()}"
    if name not in modes[1:]:
        raise invalid("blender", f"is {mode!r}, allowed: standard, unitless, raw")
    levels = scene_pb2.BlenderLevels(mode=scene_pb2.BlenderLightingMode.Value(name))
    set_fields(levels, lumens_per_watt=lumens_per_watt)
    return levels


def load(request: scene_pb2.LoadSceneRequest) -> Steps[Loaded]:
    """Loads the scene of a request without missing files."""
    answer = yield from _load(request)
    return Loaded(id=answer.scene_id, lease_id=answer.lease_id, remarks=tuple(answer.remarks))


def _load(request: scene_pb2.LoadSceneRequest) -> Steps[scene_pb2.LoadSceneResponse]:
    data = yield Unary("SceneService/LoadScene", request.SerializeToString())
    return _wire.parsed(scene_pb2.LoadSceneResponse, data)


def edit(scene: SceneLike, edits: Sequence[Edit], lease_s: float | None) -> Steps[Loaded]:
    """Makes a revision of the scene.  Names of lights become ids first."""
    names: dict[str, list[int]] = {}
    if any(isinstance(e.light, str) for e in edits):
        found = yield from lights(scene)
        for light, name in zip(found.ids, found.names):
            names.setdefault(name, []).append(int(light))
    request = scene_pb2.EditLightsRequest(scene_id=scene.id, edits=resolved(edits, names))
    set_fields(request, lease_s=lease_s)
    data = yield Unary("SceneService/EditLights", request.SerializeToString())
    answer = _wire.parsed(scene_pb2.EditLightsResponse, data)
    return Loaded(id=answer.scene_id, lease_id=answer.lease_id, new_lights=tuple(answer.light_ids))


def renew(scene: SceneLike, lease_s: float, lease_id: str = "") -> Steps[str]:
    """Extends a lease, or makes a new one without `lease_id`.  Returns its id.

    lease_s: from now [s], above 0.  Errors: NotFound for a lease that has ended.
    """
    request = scene_pb2.RenewLeaseRequest(scene_id=scene.id, lease_id=lease_id)
    set_fields(request, lease_s=lease_s)
    data = yield Unary("SceneService/RenewLease", request.SerializeToString())
    return _wire.parsed(scene_pb2.RenewLeaseResponse, data).lease_id


def release(scene: SceneLike, lease_id: str = "", *, break_leases: bool = False) -> Steps[bool]:
    """Ends a lease, and unloads the scene unless another lease keeps it.

    lease_id: by default that of `load`.  break_leases: ends all leases, which needs the role admin.  Returns whether
    another lease keeps the scene.  Errors: FailedPrecondition if the scene is leased and no lease is given.
    """
    request = scene_pb2.ReleaseSceneRequest(scene_id=scene.id, break_leases=break_leases,
                                            lease_id=lease_id or getattr(scene, "lease_id", ""))
    data = yield Unary("SceneService/ReleaseScene", request.SerializeToString())
    return _wire.parsed(scene_pb2.ReleaseSceneResponse, data).still_loaded


@dataclasses.dataclass(frozen=True)
class _File:
    path: pathlib.Path
    digest: bytes
    size: int


def _hashed(path: pathlib.Path) -> _File:
    digest, size = hashlib.sha256(), 0
    try:
        with path.open("rb") as stream:
            while chunk := stream.read(_CHUNK):
                digest.update(chunk)
                size += len(chunk)
    except OSError as error:
        raise invalid("path", f"{path} cannot be read: {error.strerror}") from None
    return _File(path, digest.digest(), size)


UploadProgress = Callable[[str, int, int], None]


def upload(path: str | os.PathLike[str], root: str | os.PathLike[str] | None, request: scene_pb2.LoadSceneRequest,
           progress: UploadProgress | None) -> Steps[Loaded]:
    """Loads a scene file of this machine.  client/library/upload.cpp does the same in C++."""
    main = pathlib.Path(path).resolve()
    if not main.is_file():
        raise NotFound(f"{os.fspath(path)}: no such file")
    folder = main.parent if root is None else pathlib.Path(root).resolve()
    if not folder.is_dir():
        raise NotFound(f"{os.fspath(root or folder)}: no such directory")
    if not main.is_relative_to(folder):
        raise invalid("path", f"{main} is not inside {folder}")
    request.manifest.main = main.relative_to(folder).as_posix()
    files: dict[str, _File | None] = {}  # by name; None: there is no such file

    def add(name: str) -> Steps[None]:
        place = (folder / name.lstrip("/")).resolve()
        files[name] = None
        asset = request.manifest.assets.add(name=name)
        if place.is_file():
            # Symbolic links out of the root are refused too.
            if not place.is_relative_to(folder):
                raise invalid("path", f"{name} is outside {folder}; only files inside it are sent")
            files[name] = file = yield Work(lambda: _hashed(place))
            asset.sha256 = file.digest

    yield from add(request.manifest.main)
    for _ in range(_ROUNDS):
        answer = yield from _load(request)
        if not answer.missing:
            return Loaded(id=answer.scene_id, lease_id=answer.lease_id, remarks=tuple(answer.remarks))
        wanted: dict[bytes, str] = {}
        for asset in answer.missing:
            if asset.name not in files:
                yield from add(asset.name)
            file = files[asset.name]
            if file is not None:
                wanted.setdefault(file.digest, asset.name)
        for digest, received in (yield from _missing(wanted)):
            if digest not in wanted:
                raise _wire.Broken("the server requests a file that is not in the manifest")
            file = files[wanted[digest]]
            assert file is not None
            yield from _send(wanted[digest], file, received, progress)
    raise _wire.Broken(f"the server still requests files after {_ROUNDS} rounds")


def _missing(digests: Iterable[bytes]) -> Steps[list[tuple[bytes, int]]]:
    """Those of the files that the server does not hold, and how much of each it has."""
    request = scene_pb2.FindMissingAssetsRequest(sha256=digests)
    data = yield Unary("SceneService/FindMissingAssets", request.SerializeToString())
    answer = _wire.parsed(scene_pb2.FindMissingAssetsResponse, data)
    asked, lacks = set(request.sha256), list(answer.missing_sha256)
    if len(answer.received_bytes) != len(lacks) or not set(lacks) <= asked:
        raise _wire.Broken("FindMissingAssetsResponse has files that were not requested, or lacks their bytes")
    return list(zip(answer.missing_sha256, answer.received_bytes))


def _send(name: str, file: _File, offset: int, progress: UploadProgress | None) -> Steps[None]:
    """Sends until the server has the whole file."""
    tries, pause_s = 0, 0.05
    while True:
        before = offset
        try:
            data = yield Upload("SceneService/UploadAsset", _requests(name, file, offset, progress))
        except (Unavailable, FailedPrecondition) as error:
            yield Pause(pause_s if error.retry_after_s is None else error.retry_after_s)
            left = yield from _missing([file.digest])
            if not left:
                return  # another client has sent the file
            offset = left[0][1]
            tries = 0 if offset > before else tries + isinstance(error, Unavailable)
            if tries == _TRIES:
                raise
            pause_s = min(2 * pause_s, 2.0)
        else:
            if _wire.parsed(scene_pb2.UploadAssetResponse, data).received_bytes != file.size:
                raise InvalidArgument(f"{file.path}: changed while it was sent")
            return


def _requests(name: str, file: _File, offset: int, progress: UploadProgress | None) -> Iterator[bytes]:
    header = scene_pb2.AssetHeader(sha256=file.digest, size_bytes=file.size, offset_bytes=offset)
    yield scene_pb2.UploadAssetRequest(header=header).SerializeToString()
    with file.path.open("rb") as stream:
        stream.seek(offset)
        while chunk := stream.read(_CHUNK):
            yield scene_pb2.UploadAssetRequest(chunk=chunk).SerializeToString()
            offset += len(chunk)
            if progress is not None:
                progress(name, offset, file.size)
