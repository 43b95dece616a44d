"""Answers that do not fit their requests are errors of the package.  The server is a fake."""
import asyncio
import contextlib
import re
import resource
import traceback

import grpc
import lucerna
import numpy as np
import pytest
from conftest import WAIT_S
from lucerna.v1 import lighting_pb2, render_pb2, scene_pb2
from test_retries import INFO, Fake

LOADED = scene_pb2.LoadSceneResponse(scene_id="0" * 64).SerializeToString()


class FakeWithImages(Fake):
    """The answer to RenderImage is a stream."""

    def service(self, details):
        if details.method.endswith("RenderImage"):
            return grpc.unary_stream_rpc_method_handler(self.methods["RenderImage"])
        return super().service(details)


def raises(call, match, **methods):
    """The call, a function of a scene, meets a broken server, in both clients."""
    answers = {name: m if callable(m) else lambda request, context, m=m: m for name, m in methods.items()}
    with FakeWithImages(GetServerInfo=lambda *_: INFO, LoadScene=lambda *_: LOADED, **answers) as fake:
        with lucerna.connect(fake.target, timeout=WAIT_S) as server:
            with pytest.raises(lucerna.Error, match="the server broke the protocol: .*" + match) as caught:
                call(server.load("x.pbrt"))
            assert caught.value.code is grpc.StatusCode.INTERNAL

        async def run():
            async with lucerna.aio.connect(fake.target, timeout=WAIT_S) as server:
                await call(await server.load("x.pbrt"))
        with pytest.raises(lucerna.Error, match="the server broke the protocol: .*" + match):
            asyncio.run(run())


def irradiance(**changes):
    fields = {"irradiance_lx": [1] * 6, "illuminance_lx": [1, 1], "zero_bound_lx": [0, 0], "unsampled_bound_lx": [0, 0]}
    return lighting_pb2.EstimateIrradianceResponse(**fields | changes).SerializeToString()


def ask(scene):
    return scene.irradiance(np.zeros((2, 3)), [0, 0, 1])


@pytest.mark.parametrize("changes, match", [
    ({"illuminance_lx": [1]}, "illuminance_lx has 1 entries, expected 2"),
    ({"illuminance_lx": []}, "illuminance_lx has 0 entries, expected 2"),
    ({"irradiance_lx": [1] * 9}, "irradiance_lx has 9 entries, expected 6"),
    ({"illuminance_lx": [1, np.nan]}, "illuminance_lx has a number that is not finite"),
    ({"status": [1]}, "status has 1 entries, expected 2"),
    ({"cost": {"cpu_time_s": np.inf}}, "cpu_time_s has a number that is not finite"),
])
def test_arrays_fit_the_points(changes, match):
    raises(ask, match, EstimateIrradiance=irradiance(**changes))


def test_bytes_that_are_no_message_are_broken():
    raises(ask, "", EstimateIrradiance=b"\xff\xff")
    raises(lambda scene: scene.description(), "", GetScene=b"\xff\xff")


def test_bits_are_complete():
    raises(lambda scene: scene.visible(np.zeros((9, 3)), np.ones((9, 3))), "visible has 1 bytes, expected 2",
           TestVisibility=lighting_pb2.TestVisibilityResponse(visible=b"\xff", count=9).SerializeToString())


def test_lists_have_an_end():
    raises(lambda scene: scene.lights(), "the list has no end",
           ListLights=scene_pb2.ListLightsResponse(next_page_token="a").SerializeToString())
    raises(lambda scene: scene.power(), "the list has no end", EstimatePower=lighting_pb2.EstimatePowerResponse(
        lights=[lighting_pb2.LightPower()], next_page_token="a").SerializeToString())


def tile(x=0, blocks=1, value=1.0, **changes):
    fields = {"rect": {"x0": x, "x1": x + 1, "y1": 1}, "image_width": 2, "image_height": 1, "block_count": blocks,
              "sum": np.full(3, value).tobytes(), "deviation": bytes(24)}
    return render_pb2.Tile(**fields | changes)


def picture(*tiles, for_ever=False):
    data = [render_pb2.RenderImageResponse(tile=t).SerializeToString() for t in tiles]

    def stream(request, context):
        yield from data
        while for_ever and context.is_active():
            yield data[-1]
    return stream


@pytest.mark.parametrize("stream, match", [
    (picture(), "the picture ended with 0 pixels"),
    (picture(tile(0)), "the picture ended with 1 pixels, of 2"),
    (picture(tile(0), for_ever=True), "came again without more blocks"),
    (picture(tile(0), tile(2)), "outside of its picture"),
    (picture(tile(0, image_width=3), tile(0, image_width=3, rect={"x1": 2, "y1": 1}, sum=bytes(48),
                                          deviation=bytes(48))), "overlaps other tiles"),
    (picture(tile(0), tile(1, image_width=3)), "of another picture"),
    (picture(tile(0), tile(1, value=np.nan)), "not finite"),
    (picture(tile(0, sum=b"")), "a plane of a tile has 0 bytes"),
    (picture(tile(0, blocks=0)), "no blocks"),
    (picture(tile(0, image_width=1 << 20, image_height=1 << 20)), "more than 2"),
])
def test_pictures_are_whole(stream, match):
    raises(lambda scene: scene.render(), match, RenderImage=stream)


def test_a_tile_is_the_requested_one():
    raises(lambda scene: scene.tile((0, 0, 1, 1)), "requested was",
           RenderTile=render_pb2.RenderTileResponse(tile=tile(1)).SerializeToString())


@contextlib.contextmanager
def memory_for(more_bytes):
    """The process may take no more than these beside what it has."""
    with open("/proc/self/statm", encoding="ascii") as file:
        now = int(file.read().split()[0]) * resource.getpagesize()
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (now + more_bytes, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def test_a_picture_takes_memory_for_the_pixels_that_came():
    with memory_for(2 << 30):
        raises(lambda scene: scene.render(), "the picture ended with 1 pixels, of 1073741824",
               RenderImage=picture(tile(0, image_width=1 << 15, image_height=1 << 15)))


# As in tests/e2e/hostile_server_test.py.
HOSTILE = "\x1b]0;owned\x07\x1b[2J \x9b31m \u202egnp.exe\u2066 \x7f\b\r \"quoted\", name"
OBEYED = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def test_errors_show_texts_of_the_server_as_plain_text():
    def fail(request, context):
        context.abort(grpc.StatusCode.NOT_FOUND, HOSTILE)

    async def ask_too(target):
        async with lucerna.aio.connect(target, timeout=WAIT_S) as server:
            await server.load("x.pbrt")
    with Fake(GetServerInfo=lambda *_: INFO, LoadScene=fail) as fake:
        with lucerna.connect(fake.target, timeout=WAIT_S) as server, pytest.raises(lucerna.NotFound) as caught:
            server.load("x.pbrt")
        with pytest.raises(lucerna.NotFound) as caught_too:
            asyncio.run(ask_too(fake.target))
    for error in (caught.value, caught_too.value):
        shown = "".join(traceback.format_exception(error))
        assert "owned" in shown and not OBEYED.search(shown), repr(shown)
        assert "\\u001b[2J \\u009b31m \\u202egnp.exe" in str(error)


def test_all_texts_of_an_error_are_plain():
    error = lucerna.Error(HOSTILE, reason=HOSTILE, request_id=HOSTILE,
                          violations=(lucerna.FieldViolation(HOSTILE, HOSTILE),))
    violation = error.violations[0]
    for text in (str(error), error.message, error.reason, error.request_id, violation.field, violation.description):
        assert "owned" in text and not OBEYED.search(text), repr(text)
    assert str(lucerna.Error("two\n\tlines of \u00fcnicode \u6f22")) == "two\n\tlines of \u00fcnicode \u6f22"


@pytest.mark.parametrize("seconds", [1e10, 1e18, 1e300, float("inf")])
def test_a_timeout_may_be_longer_than_clocks_count(seconds):
    with Fake(GetServerInfo=lambda *_: INFO) as fake, lucerna.connect(fake.target, timeout=seconds) as server:
        assert server.info().version == "fake"
