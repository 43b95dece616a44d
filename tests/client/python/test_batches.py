"""Any number of points goes in batches that the server accepts, with the bits of a single request."""
import asyncio
import dataclasses
import os
import signal
import sys
import time

import grpc
import lucerna
import numpy as np
import pytest
from conftest import REFERENCE, WAIT_S
from lucerna import _batches, _wire
from lucerna.v1 import lighting_pb2, lighting_pb2_grpc

UP = (0.0, 0.0, 1.0)
COUNT = 20001  # more than two good batches, and no multiple of eight bits


@pytest.fixture(scope="module")
def narrow():
    """A server with the least limits."""
    with lucerna.local(REFERENCE, threads=2, patience=WAIT_S, timeout=WAIT_S,
                       arguments=["--max-batch-items", "1024", "--max-message-bytes", "1048576"]) as running:
        yield running


@pytest.fixture(scope="module")
def crowd():
    """Many points; one of them is not finite."""
    points = np.random.default_rng(11).uniform((-2, -2, 0.1), (2, 2, 2), (COUNT, 3))
    points[12345, 1] = np.nan
    return points


def same(a, b):
    """Whether two answers are equal, but for their cost."""
    for field in dataclasses.fields(a):
        if field.name in ("cost", "points", "estimates", "shares"):
            continue
        x, y = getattr(a, field.name), getattr(b, field.name)
        assert (x is None) == (y is None), field.name
        if isinstance(x, list):
            assert x == y, field.name
            continue
        assert x is None or np.array_equal(x, y, equal_nan=x.dtype.kind == "f"), field.name


def calls_of(server, items):
    ends = np.nan_to_num(items[::-1])
    scene = server.load("many_points.pbrt")
    samples = scene.sample_li(items, samples=2, seed=1, test_visibility=True)
    return {
        "irradiance": scene.irradiance(items, UP, samples=1, bounces=0, seed=1),
        "sample_li": samples,
        "sample_le": scene.sample_le(COUNT, seed=1),
        "pdf_li": scene.pdf_li(items, UP, light=3),
        "le": scene.le(items, UP),
        "segments": scene.visible(items, ends),
        "rays": scene.visible(items, directions=UP, lengths_m=np.linspace(0.1, 3, COUNT)),
        "pdf_le": scene.pdf_le(items, UP, light=3),
    }


def test_limits_of_the_server_do_not_change_the_bits(server, narrow, crowd):
    wide, small = calls_of(server, crowd), calls_of(narrow, crowd)
    for name, answer in wide.items():
        same(answer, small[name])
        if name != "sample_le":
            status = answer.status.reshape(COUNT, -1)
            assert np.all(status[12345] == 7) and np.all(np.delete(status, 12345, axis=0) != 7), name
    assert wide["irradiance"].illuminance.max() > 0 and 0 < wide["segments"].visible.mean() < 1
    assert wide["irradiance"].cost.samples == small["irradiance"].cost.samples > 0


def test_one_request_has_the_same_bits(server, crowd):
    scene = server.load("rectangle.pbrt")
    got = scene.irradiance(crowd, UP, samples=2, bounces=0, seed=5, first_item=100)
    request = lighting_pb2.EstimateIrradianceRequest(scene_id=scene.id, bounces=0)
    request.receivers.offsets_m.extend(crowd.ravel().tolist())
    request.normals.extend(UP * COUNT)
    request.accuracy.samples = 2
    request.seed.seed, request.seed.first_item = 5, 100
    with grpc.insecure_channel(server.target) as channel:
        whole = lighting_pb2_grpc.LightingServiceStub(channel).EstimateIrradiance(request, timeout=WAIT_S)
    assert np.array_equal(got.illuminance, np.array(whole.illuminance_lx, np.float32))
    assert np.array_equal(got.irradiance.ravel(), np.array(whole.irradiance_lx, np.float32))
    assert got.status.tolist() == list(whole.status)


def test_shares_of_many_lights_fit_the_messages(server, narrow, crowd):
    """400 shares of 3000 points take 19 MB; the narrow server sends 1 MiB at once."""
    wide, small = (s.load("many_points.pbrt").irradiance(crowd[:3000], UP, samples=1, bounces=0, per_light=True)
                   for s in (server, narrow))
    assert np.array_equal(wide.shares.illuminance, small.shares.illuminance) and wide.shares.illuminance.max() > 0
    assert wide.shares.illuminance.shape == (400, 3000)


def test_samples_to_a_target_do_not_depend_on_the_batches(server, narrow, crowd):
    accuracy = lucerna.Accuracy(error=0.5, max_samples=64)
    wide, small = (s.load("many_points.pbrt").sample_li(crowd[:200], UP, accuracy=accuracy) for s in (server, narrow))
    same(wide, small)
    same(wide.estimates, small.estimates)


def test_arrays_of_an_answer_are_below_the_stated_bound(server, crowd):
    """The bound cuts batches, so an answer above it could exceed the limit of a message."""
    scene = server.load("many_points.pbrt")
    sizes = []

    class Spy:
        def __init__(self, transport):
            self.transport, self.connection = transport, transport.connection

        def run(self, steps, timeout_s):
            step = next(steps)
            try:
                while True:
                    result = self.transport._take(step, None)
                    sizes.append(sum(map(len, result)) if isinstance(result, list) else len(result))
                    step = steps.send(result)
            except StopIteration as end:
                return end.value

    scene._transport = Spy(scene._transport)
    real, seen = _batches.in_batches, []

    def spy(request, *, per_item, fixed=_batches.FIXED, weight=1, **more):
        seen.append((request.items * weight * per_item + fixed))
        return (yield from real(request, per_item=per_item, fixed=fixed, weight=weight, **more))

    _batches.in_batches = spy
    try:
        few = crowd[:1000]
        for call in (lambda: scene.irradiance(few, UP, samples=32, bounces=0),
                     lambda: scene.irradiance(few, UP, error=0.5, bounces=0),
                     lambda: scene.irradiance(few[:50], UP, samples=32, bounces=0, per_light=True),
                     lambda: scene.sample_li(few, test_visibility=True), lambda: scene.sample_le(1000),
                     lambda: scene.pdf_li(few, UP, light=1), lambda: scene.le(few, UP),
                     lambda: scene.visible(few, few), lambda: scene.pdf_le(few, UP, light=1)):
            sizes.clear()
            call()
            assert 0 < sizes[-1] <= seen[-1]
    finally:
        _batches.in_batches = real


def test_new_limits_of_a_running_server_count(crowd, tmp_path):
    """A connection remembers the limits.  After a refusal it asks again, and sends smaller batches."""
    settings = tmp_path / "lucernad.toml"
    settings.write_text("max-batch-items = 8192\n")
    with lucerna.local(REFERENCE, patience=WAIT_S, timeout=WAIT_S, arguments=["--config", str(settings)]) as server:
        scene = server.load("rectangle.pbrt")

        async def ask():
            async with lucerna.aio.connect(server.target, timeout=WAIT_S) as client:
                other = client.scene(scene.id)
                before = scene.irradiance(crowd, UP, samples=1, bounces=0)
                same(before, await other.irradiance(crowd, UP, samples=1, bounces=0))
                settings.write_text("max-batch-items = 1024\n")
                os.kill(server.process_id, signal.SIGHUP)
                end = time.monotonic() + WAIT_S
                while server.info().limits.max_batch_items != 1024:
                    assert time.monotonic() < end
                    time.sleep(0.02)
                same(before, scene.irradiance(crowd, UP, samples=1, bounces=0))
                same(before, await other.irradiance(crowd, UP, samples=1, bounces=0))
        asyncio.run(ask())


def test_progress_counts_all_points(server, crowd, capsys):
    seen = []
    scene = server.load("rectangle.pbrt")
    scene.irradiance(crowd, UP, samples=1, bounces=0, progress=lambda done, total: seen.append((done, total)))
    assert seen == [(8192, COUNT), (16384, COUNT), (COUNT, COUNT)]
    pytest.importorskip("tqdm")
    scene.irradiance(crowd, UP, samples=1, bounces=0, progress=True)
    assert "20.0k/20.0k" in capsys.readouterr().err


def test_progress_without_tqdm_shows_nothing(server, crowd, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    server.load("rectangle.pbrt").irradiance(crowd, UP, samples=1, bounces=0, progress=True)
    assert capsys.readouterr().err == ""


def test_empty_batches_have_empty_answers(server):
    scene = server.load("many_points.pbrt")
    none = np.zeros((0, 3))
    assert scene.irradiance(none, UP).illuminance.shape == (0,)
    assert scene.irradiance(none, UP, per_light=True).shares.illuminance.shape[1:] == (0,)
    assert scene.sample_li(none, error=0.1).value.shape == (0, 3)
    assert scene.sample_li(none, samples=3).value.shape == (0, 3, 3)
    assert scene.sample_le(0).points.shape == (0, 3) and scene.visible(none, none).visible.shape == (0,)
    assert scene.le(none, none).radiance.shape == (0, 3) and scene.pdf_li(none, none, light=1).density.shape == (0,)


def test_points_have_the_origin_of_the_command_line(server, ask):
    """Far from zero the offsets are relative to the middle, which keeps differences accurate."""
    far = np.array([[1e6, -3e5, 7.0], [1e6 + 0.1, -3e5 - 0.25, 7.0]])
    scene = server.load("infinite.pbrt")
    text = np.concatenate([far, np.broadcast_to(UP, far.shape)], axis=1)
    wanted = ask("irradiance", scene.id, "--points", "-", "--samples", 4, "--bounces", 0, points=text)
    got = scene.irradiance(far, UP, samples=4, bounces=0)
    assert got.illuminance.tolist() == np.array(wanted["illuminanceLx"], np.float32).tolist()
    assert lucerna._points.origin_of(far).tolist() == [1000000.05, -300000.125, 7.0]
    assert lucerna._points.origin_of(np.array([[-1.0, 0, 2], [1, 0, 2]])).tolist() == [0, 0, 2]
    # More than eight times as far away as half of their extent.
    assert lucerna._points.origin_of(np.array([[8.5, 7.5, -8.5], [10.5, 8.5, -6.5]])).tolist() == [9.5, 8, 0]
    # Points that are not finite do not count.
    for bad in (np.nan, np.inf, -np.inf):
        assert lucerna._points.origin_of(np.array([[99, bad, 0], *far])).tolist() == [1000000.05, -300000.125, 7.0]
    assert lucerna._points.origin_of(np.full((2, 3), np.nan)).tolist() == [0, 0, 0]


@pytest.mark.parametrize("numbers", [[], [0], [127, 128, 300, 2**32, 2**64 - 1, 5], [1] * 9])
def test_varints_are_read_as_protobuf_writes_them(numbers):
    message = lighting_pb2.SampleLiResponse(light_ids=numbers)
    answer = _wire.Answer(message.SerializeToString(), lighting_pb2.SampleLiResponse.DESCRIPTOR)
    assert answer.varints("light_ids").tolist() == numbers


def test_answers_may_come_in_pieces():
    """The format allows several pieces of a packed array, and unpacked numbers."""
    a, b = lighting_pb2.LeResponse(light_ids=[1, 400]), lighting_pb2.LeResponse(light_ids=[7], radiance_cd_m2=[1, 2.5])
    single = bytes([1 << 3 | 5]) + np.float32(9).tobytes() + bytes([2 << 3, 6])
    answer = _wire.Answer(a.SerializeToString() + b.SerializeToString() + single, lighting_pb2.LeResponse.DESCRIPTOR)
    assert answer.varints("light_ids").tolist() == [1, 400, 7, 6]
    assert answer.floats("radiance_cd_m2").tolist() == [1, 2.5, 9]


@pytest.mark.parametrize("data", [b"\x0a\x05abc", b"\x80", b"\x0b", b"\x0d\x00\x00"])
def test_bytes_that_are_no_message_are_refused(data):
    with pytest.raises(ValueError, match="the answer is no lucerna.v1.LeResponse"):
        _wire.Answer(data, lighting_pb2.LeResponse.DESCRIPTOR)
