#!/usr/bin/python3
"""Compares the processor time of rays, and the memory, of two builds on the same grey scenes, in turns.

    tests/bench/compare_builds.py BEFORE NOW [--repeats 7]

BEFORE and NOW are build folders with bin/lucernad; the contract is that of this checkout.  Prints for each scene of
tests/data/reference below:
- the rays of a tile of 16 samples a pixel, of both builds,
- the time of a ray in NOW over that in BEFORE: the median,
- the bytes of the scene before its first query in NOW over those in BEFORE.
Needs python3-grpcio, python3-protobuf and protobuf-compiler.
"""
import argparse
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

import grpc

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["point", "rectangle", "sphere", "triangle", "cylinder", "textured", "environment", "portal", "many_points",
          "many_triangles", "bounces"]
SAMPLES = 16
DEADLINE_S = 120  # of a call


class Server:
    def __init__(self, build, folder=ROOT / "tests/data/reference", threads=2):
        program = build / "bin/lucernad"
        if not program.is_file():
            sys.exit(f"compare_builds.py: {program} does not exist, allowed: a folder with bin/lucernad")
        self.process = subprocess.Popen(
            [str(program), "--scene-root", str(folder), "--threads", str(threads), "--listen", "127.0.0.1:0"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        line = self.process.stdout.readline()
        match = re.match(r"listening on (\S+)", line)
        if not match:
            self.stop()
            sys.exit(f"compare_builds.py: {program} did not start: {line!r}")
        self.channel = grpc.insecure_channel(match[1], options=[("grpc.max_receive_message_length", 1 << 28)])

    def call(self, method, request, response):
        return self.start(self.channel.unary_unary, method, request, response)

    def stream(self, method, request, response):
        return self.start(self.channel.unary_stream, method, request, response)

    @staticmethod
    def start(kind, method, request, response):
        call = kind(f"/lucerna.v1.{method}", request_serializer=lambda m: m.SerializeToString(),
                    response_deserializer=response.FromString)
        return call(request, timeout=DEADLINE_S)

    def stop(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


def messages(folder):
    """The modules of the contract, generated into the folder."""
    files = sorted(str(f.relative_to(ROOT / "proto")) for f in (ROOT / "proto/lucerna/v1").glob("*.proto"))
    subprocess.run(["protoc", f"-I{ROOT / 'proto'}", f"--python_out={folder}", *files], check=True)
    sys.path.insert(0, folder)
    from lucerna.v1 import accuracy_pb2, render_pb2, scene_pb2
    return accuracy_pb2, render_pb2, scene_pb2


def compare(servers, modules, scene, repeats):
    """The rays of a tile, the median of the ratio of seconds for each ray, and the ratio of the scene's bytes."""
    accuracy, render, scenes = modules
    ids = [s.call("SceneService/LoadScene", scenes.LoadSceneRequest(path=f"{scene}.pbrt"),
                  scenes.LoadSceneResponse).scene_id for s in servers]
    before, now = (sum(part.bytes for part in s.call(
        "SceneService/GetScene", scenes.GetSceneRequest(scene_id=i), scenes.GetSceneResponse).parts)
                   for s, i in zip(servers, ids))
    ratios = []
    for seed in range(repeats):
        seconds, rays = [0, 0], [0, 0]
        for k in (0, 1) if seed % 2 == 0 else (1, 0):
            request = render.RenderTileRequest(scene_id=ids[k], seed=seed, accuracy=accuracy.Accuracy(samples=SAMPLES))
            cost = servers[k].call("RenderService/RenderTile", request, render.RenderTileResponse).cost
            rays[k] = cost.camera_rays + cost.indirect_rays + cost.shadow_rays
            seconds[k] = cost.cpu_time_s / rays[k]
        ratios.append(seconds[1] / seconds[0])
    return rays, statistics.median(ratios), now / before


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=pathlib.Path)
    parser.add_argument("now", type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=7, choices=range(1, 101), metavar="1..100")
    options = parser.parse_args()
    servers = []
    try:
        for build in (options.before, options.now):
            servers.append(Server(build))
        with tempfile.TemporaryDirectory() as folder:
            modules = messages(folder)
            ratios = []
            for scene in SCENES:
                rays, ratio, memory = compare(servers, modules, scene, options.repeats)
                ratios.append(ratio)
                print(f"{scene:16} rays {rays[0]:8} {rays[1]:8}   time of a ray {ratio:.3f}   bytes {memory:.3f}", flush=True)
        print(f"median of the scenes {statistics.median(ratios):.3f}")
    finally:
        for server in servers:
            server.stop()


if __name__ == "__main__":
    main()
