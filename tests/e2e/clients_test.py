#!/usr/bin/python3
"""Clients of others call lucernad over TLS with a token: Python's grpcio, and `buf curl`.

    tests/e2e/clients_test.py BUILD_DIR python|buf

buf is an npm tool that `deploy/install-deps.sh --tests` installs.  Without it, `buf` is skipped.  Where LUCERNA_BUF
names it, it must exist.
"""
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import grpc

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
sys.path[:0] = [str(ROOT / "tests/server"), str(BUILD / "tests/e2e/stubs")]
from certificates import Authority  # noqa: E402
from lucerna.v1 import accuracy_pb2, lighting_pb2, lighting_pb2_grpc  # noqa: E402
from lucerna.v1 import render_pb2, render_pb2_grpc, scene_pb2, scene_pb2_grpc  # noqa: E402
from lucernad import Lucernad, expect  # noqa: E402

WAIT_S = 600  # ends tests that hang
SKIPPED = 77
TOKEN = "a-secret-for-the-clients-of-others"
SERVING, NOT_FOUND = b"\x08\x01", grpc.StatusCode.NOT_FOUND
SERVICES = ("SceneService", "LightingService", "RenderService", "AdminService")


def close(got, wanted, what):
    expect(abs(got - wanted) < 1e-5 * wanted, f"{what}: {got}, expected {wanted}")


def fails(code, text, call):
    try:
        call()
    except grpc.RpcError as error:
        expect(error.code() == code and text in error.details(), f"{error.code()}: {error.details()}; expected {text}")
    else:
        expect(False, f"the call succeeds, expected {code}: {text}")


def python_asks(channel):
    """The light of 10 cd is 3.2 m above the point."""
    scenes = scene_pb2_grpc.SceneServiceStub(channel)
    light = lighting_pb2_grpc.LightingServiceStub(channel)
    scene = scenes.LoadScene(scene_pb2.LoadSceneRequest(path="point.pbrt"), timeout=WAIT_S).scene_id
    power = light.EstimatePower(lighting_pb2.EstimatePowerRequest(scene_id=scene), timeout=WAIT_S)
    close(power.total.power_lm, 125.66370614, "power")
    here = accuracy_pb2.Points(offsets_m=[1.2, -1.5, 0])
    sample = light.SampleLi(lighting_pb2.SampleLiRequest(scene_id=scene, receivers=here,
                                                         seed=lighting_pb2.Seed(seed=1)), timeout=WAIT_S)
    close(sample.value[0], 10 / 3.2**2, "sample")
    picture = render_pb2_grpc.RenderServiceStub(channel).RenderImage(
        render_pb2.RenderImageRequest(scene_id=scene, accuracy=accuracy_pb2.Accuracy(samples=1)), timeout=WAIT_S)
    expect(sum(r.HasField("tile") for r in picture) > 0, "the picture has no tile")


def health_answers(channel):
    """The standard health service, which needs no token.  Requests are HealthCheckRequest{service}."""
    def check(service):
        name = service.encode()
        return channel.unary_unary("/grpc.health.v1.Health/Check")(
            b"\x0a" + bytes([len(name)]) + name if name else b"", timeout=WAIT_S)

    for service in ("", *(f"lucerna.v1.{s}" for s in SERVICES)):
        expect(check(service) == SERVING, f"health of {service!r}")
    fails(NOT_FOUND, "", lambda: check("lucerna.v1.NoService"))
    watch = channel.unary_stream("/grpc.health.v1.Health/Watch")(b"", timeout=WAIT_S)
    expect(next(watch) == SERVING, "health, watched")
    watch.cancel()


def reflection_lists_the_services(channel):
    """The standard reflection service, which needs no token.  The request is list_services of "*"."""
    call = channel.stream_stream("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo")
    answer = next(call(iter([b"\x3a\x01*"]), timeout=WAIT_S))
    for service in (*(f"lucerna.v1.{s}" for s in SERVICES), "grpc.health.v1.Health"):
        expect(service.encode() in answer, f"reflection does not list {service}: {answer}")


def python(server, authority, strangers):
    trust = grpc.ssl_channel_credentials(authority.certificate.read_bytes())
    with grpc.secure_channel(f"localhost:{server.port}", grpc.composite_channel_credentials(
            trust, grpc.access_token_call_credentials(TOKEN))) as channel:
        python_asks(channel)
    scenes = scene_pb2.ListScenesRequest()
    with grpc.secure_channel(f"localhost:{server.port}", trust) as channel:
        health_answers(channel)
        reflection_lists_the_services(channel)
        listing = scene_pb2_grpc.SceneServiceStub(channel).ListScenes
        fails(grpc.StatusCode.UNAUTHENTICATED, "the call has no token", lambda: listing(scenes, timeout=WAIT_S))
        fails(grpc.StatusCode.UNAUTHENTICATED, "does not know this token", lambda: listing(
            scenes, timeout=WAIT_S, metadata=[("authorization", "Bearer " + TOKEN[:-1])]))
    wrong = grpc.ssl_channel_credentials(strangers.certificate.read_bytes())
    with grpc.secure_channel(f"localhost:{server.port}", wrong) as channel:
        listing = scene_pb2_grpc.SceneServiceStub(channel).ListScenes
        fails(grpc.StatusCode.UNAVAILABLE, "", lambda: listing(scenes, timeout=WAIT_S))


def find_buf():
    given = os.environ.get("LUCERNA_BUF")
    if given:
        expect(os.access(given, os.X_OK), f"LUCERNA_BUF = {given}, which is no program")
        return given
    tool = ROOT / "build/buf/node_modules/.bin/buf"
    return str(tool) if tool.exists() else shutil.which("buf")


def buf(server, authority, strangers):
    """buf has no .proto files here: it gets the contract by reflection."""
    def curl(method, request, *options, ca=authority.certificate):
        return subprocess.run([find_buf(), "curl", "--protocol", "grpc", "--cacert", ca, "-d", json.dumps(request),
                               *options, f"https://localhost:{server.port}/{method}"], capture_output=True, text=True,
                              timeout=WAIT_S, check=False, cwd=server.directory.name)

    def ask(method, request):
        outcome = curl(method, request, "-H", f"authorization: Bearer {TOKEN}")
        expect(outcome.returncode == 0, f"{method}: {outcome.returncode}: {outcome.stderr}")
        return json.loads(outcome.stdout)

    scene = ask("lucerna.v1.SceneService/LoadScene", {"path": "point.pbrt"})["sceneId"]
    power = ask("lucerna.v1.LightingService/EstimatePower", {"sceneId": scene, "lightIds": [1]})
    close(power["total"]["powerLm"], 125.66370614, "power")
    expect(ask("grpc.health.v1.Health/Check", {}) == {"status": "SERVING"}, "health")
    # buf's exit status is the code of gRPC times 8, or 1 without an answer.
    stranger = curl("lucerna.v1.SceneService/ListScenes", {})
    expect(stranger.returncode == 16 * 8 and "the call has no token" in stranger.stderr,
           f"without a token: {stranger.returncode}: {stranger.stderr}")
    # Without reflection, whose failure buf reports without its reason.
    distrusts = curl("lucerna.v1.SceneService/ListScenes", {}, "--schema", ROOT, "--reflect=false",
                     ca=strangers.certificate)
    expect(distrusts.returncode != 0 and "certificate" in distrusts.stderr,
           f"with another authority: {distrusts.returncode}: {distrusts.stderr}")


def main():
    part = {"python": python, "buf": buf}[sys.argv[2]]
    if part is buf and find_buf() is None:
        print("skipped: buf is not installed; deploy/install-deps.sh --tests installs it")
        sys.exit(SKIPPED)
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        authority, strangers = Authority(directory, "authority"), Authority(directory, "strangers")
        certificate, key = authority.issue("server")
        tokens = directory / "tokens.toml"
        digest = hashlib.sha256(TOKEN.encode()).hexdigest()
        tokens.write_text(f'[[token]]\nname = "me"\nsha256 = "{digest}"\nroles = ["query", "load"]\n')
        with Lucernad(BUILD / "bin/lucernad", "--tls-cert", certificate, "--tls-key", key, "--token-file", tokens,
                      "--scene-root", ROOT / "tests/data/reference") as server:
            part(server, authority, strangers)


main()
