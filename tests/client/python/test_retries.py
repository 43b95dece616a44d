"""Calls and uploads survive a server that fails for a while.  The server is a fake, which fails as planned."""
import concurrent.futures
import hashlib
import threading

import grpc
import lucerna
import numpy as np
import pytest
from conftest import WAIT_S
from lucerna.v1 import admin_pb2, lighting_pb2, scene_pb2

MEGABYTE = 1 << 20


class Fake(grpc.GenericRpcHandler):
    """Answers calls by functions of (request, context); `calls` counts them."""

    def __init__(self, **methods):
        self.methods, self.calls = methods, []

    def service(self, details):
        name = details.method.rpartition("/")[2]
        self.calls.append(name)
        answer = self.methods[name]
        if name == "UploadAsset":
            return grpc.stream_unary_rpc_method_handler(answer)
        return grpc.unary_unary_rpc_method_handler(answer)

    def __enter__(self):
        self.server = grpc.server(concurrent.futures.ThreadPoolExecutor(8))
        self.server.add_generic_rpc_handlers((self,))
        self.target = f"127.0.0.1:{self.server.add_insecure_port('127.0.0.1:0')}"
        self.server.start()
        return self

    def __exit__(self, *_):
        self.server.stop(None).wait(WAIT_S)


def failing(times, code, answer):
    """A method that fails this many times."""
    left = [times]

    def method(request, context):
        left[0] -= 1
        if left[0] >= 0:
            context.abort(code, "planned")
        return answer
    return method


INFO = admin_pb2.GetServerInfoResponse(version="fake").SerializeToString()


def test_unavailable_is_retried_and_other_errors_are_not():
    with Fake(GetServerInfo=failing(3, grpc.StatusCode.UNAVAILABLE, INFO)) as fake:
        with lucerna.connect(fake.target, timeout=WAIT_S) as server:
            assert server.info().version == "fake" and len(fake.calls) == 4
    with Fake(GetServerInfo=failing(4, grpc.StatusCode.UNAVAILABLE, INFO)) as fake:
        with lucerna.connect(fake.target, timeout=WAIT_S) as server:
            with pytest.raises(lucerna.Unavailable, match="planned"):
                server.info()
        assert len(fake.calls) == 4
    with Fake(GetServerInfo=failing(1, grpc.StatusCode.INTERNAL, INFO)) as fake:
        with lucerna.connect(fake.target, timeout=WAIT_S) as server:
            with pytest.raises(lucerna.Error, match="planned") as error:
                server.info()
        assert len(fake.calls) == 1 and error.value.code == grpc.StatusCode.INTERNAL


class Assets:
    """The calls of an upload.  `plan` has the failure of each stream: None, or a code and the bytes that it takes."""

    def __init__(self, plan):
        self.plan, self.held, self.offsets = list(plan), {}, []

    def load(self, data, context):
        request = scene_pb2.LoadSceneRequest.FromString(data)
        answer = scene_pb2.LoadSceneResponse()
        for asset in request.manifest.assets:
            size = (self.scene.stat().st_size if asset.name == self.scene.name else 0)
            if len(self.held.get(asset.sha256, b"")) < size:
                answer.missing.append(asset)
        if not answer.missing:
            answer.scene_id = "1" * 64
        return answer.SerializeToString()

    def missing(self, data, context):
        request = scene_pb2.FindMissingAssetsRequest.FromString(data)
        answer = scene_pb2.FindMissingAssetsResponse()
        for digest in request.sha256:
            held = self.held.get(digest, b"")
            if hashlib.sha256(held).digest() != digest:
                answer.missing_sha256.append(digest)
                answer.received_bytes.append(len(held))
        return answer.SerializeToString()

    def upload(self, stream, context):
        header = scene_pb2.UploadAssetRequest.FromString(next(stream)).header
        self.offsets.append(header.offset_bytes)
        failure = self.plan.pop(0) if self.plan else None
        taken = self.held.setdefault(header.sha256, b"")
        assert header.offset_bytes == len(taken)
        for data in stream:
            if failure is not None and len(taken) - header.offset_bytes >= failure[1]:
                context.abort(failure[0], "planned")
            taken += scene_pb2.UploadAssetRequest.FromString(data).chunk
            self.held[header.sha256] = taken
        return scene_pb2.UploadAssetResponse(received_bytes=len(taken)).SerializeToString()


def upload(tmp_path, plan):
    assets = Assets(plan)
    assets.scene = tmp_path / "scene.pbrt"
    assets.scene.write_bytes(np.random.default_rng(1).bytes(3 * MEGABYTE + 17))
    with Fake(LoadScene=assets.load, FindMissingAssets=assets.missing, UploadAsset=assets.upload) as fake:
        with lucerna.connect(fake.target, timeout=WAIT_S) as server:
            scene = server.upload(assets.scene)
    assert scene.id == "1" * 64 and assets.held[hashlib.sha256(assets.scene.read_bytes()).digest()]
    return assets.offsets


def test_a_broken_upload_continues_where_it_stopped(tmp_path):
    lost = grpc.StatusCode.UNAVAILABLE
    assert upload(tmp_path, [(lost, MEGABYTE), (lost, MEGABYTE)]) == [0, MEGABYTE, 2 * MEGABYTE]


def test_an_upload_waits_for_that_of_another_client(tmp_path):
    assert upload(tmp_path, [(grpc.StatusCode.FAILED_PRECONDITION, 0)] * 7) == [0] * 8


def test_an_upload_without_progress_ends(tmp_path):
    with pytest.raises(lucerna.Unavailable, match="planned"):
        upload(tmp_path, [(grpc.StatusCode.UNAVAILABLE, 0)] * 99)


def test_an_error_ends_all_batches():
    """The first error is the result, and no batch is sent after it."""
    limits = admin_pb2.GetServerInfoResponse(limits=admin_pb2.Limits(max_batch_items=1024, max_message_bytes=MEGABYTE))
    gate = threading.Event()

    def answer(data, context):
        first = lighting_pb2.PdfLiRequest.FromString(data).receivers.offsets_m[0]
        if first > 0:  # the second batch
            context.abort(grpc.StatusCode.NOT_FOUND, "planned")
        gate.wait(WAIT_S)
        return lighting_pb2.PdfLiResponse(pdf_per_sr=[1] * 1024).SerializeToString()

    points = np.zeros((100 * 1024, 3))
    points[1024:2048, 0] = 1
    with Fake(GetServerInfo=lambda *_: limits.SerializeToString(), PdfLi=answer) as fake:
        with lucerna.connect(fake.target, timeout=WAIT_S, in_flight=2) as server:
            threading.Timer(0.2, gate.set).start()
            with pytest.raises(lucerna.NotFound, match="planned"):
                server.scene("1" * 64).pdf_li(points, (0, 0, 1), light=1)
        assert fake.calls.count("PdfLi") <= 3


def test_threads_share_a_connection(server, points):
    scene = server.load("rectangle.pbrt")
    wanted = [scene.irradiance(points, (0, 0, 1), samples=4, bounces=0, seed=seed).illuminance for seed in range(4)]
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        got = list(pool.map(lambda i: scene.irradiance(points, (0, 0, 1), samples=4, bounces=0, seed=i % 4), range(64)))
    assert all(np.array_equal(answer.illuminance, wanted[i % 4]) for i, answer in enumerate(got))
