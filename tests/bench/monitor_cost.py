#!/usr/bin/python3
"""Measures what metrics and the log cost a server that answers queries of one item.

    tests/bench/monitor_cost.py BUILD_DIR [OTHER_LUCERNAD]

One server has neither log nor metrics, the other logs each call and is scraped once a second.  They answer in turns.
The figure is the processor time of the server's process for each call, which bounds its throughput.  Unlike the wall
time, it depends little on other programs.  With OTHER_LUCERNAD, a third server is that program with its defaults.
"""
import pathlib
import statistics
import subprocess
import sys
import tempfile
import threading
import urllib.request

import grpc

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
STUBS = BUILD / "tests/e2e/stubs"
sys.path[:0] = [str(STUBS), str(ROOT / "tests/e2e")]
from lucerna.v1 import accuracy_pb2, lighting_pb2, scene_pb2, scene_pb2_grpc  # noqa: E402

ROUNDS, CALLS, THREADS = 120, 600, 2


class Server:
    def __init__(self, program, *arguments):
        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen(
            [program, "--listen", "127.0.0.1:0", "--scene-root", ROOT / "tests/data/reference", "--threads", "2",
             *arguments], stdout=subprocess.PIPE, stderr=self.log, text=True)
        self.metrics, line = None, ""
        while not line.startswith("listening on "):
            line = self.process.stdout.readline()
            if line.startswith("metrics on "):
                self.metrics = line.split()[2]
        self.channel = grpc.insecure_channel(line.split()[2])
        scene = scene_pb2_grpc.SceneServiceStub(self.channel).LoadScene(scene_pb2.LoadSceneRequest(path="point.pbrt"))
        self.request = lighting_pb2.SampleLiRequest(
            scene_id=scene.scene_id, receivers=accuracy_pb2.Points(offsets_m=[1.2, -1.5, 0]),
            seed=lighting_pb2.Seed(seed=1)).SerializeToString()

    def cpu_s(self):
        """Processor time of all threads so far."""
        return 1e-9 * sum(int((task / "schedstat").read_text().split()[0])
                          for task in pathlib.Path(f"/proc/{self.process.pid}/task").iterdir())

    def round(self):
        """Processor time of a call [s]."""
        call = self.channel.unary_unary("/lucerna.v1.LightingService/SampleLi")
        begin = self.cpu_s()
        threads = [threading.Thread(target=lambda: [call(self.request) for _ in range(CALLS // THREADS)])
                   for _ in range(THREADS)]
        for t in threads:
            t.start()
        while any(t.is_alive() for t in threads):
            if self.metrics:
                urllib.request.urlopen(self.metrics).read()
            threads[0].join(1)
        for t in threads:
            t.join()
        return (self.cpu_s() - begin) / CALLS

    def end(self):
        self.channel.close()
        self.process.terminate()
        self.process.wait(60)


def main():
    servers = {"off": Server(BUILD / "bin/lucernad", "--log-level", "off"),
               "on": Server(BUILD / "bin/lucernad", "--metrics", "127.0.0.1:0")}
    if len(sys.argv) > 2:
        servers["other"] = Server(sys.argv[2])
    try:
        times = {name: [] for name in servers}
        for r in range(ROUNDS + 1):
            for name in list(servers)[::-1 if r % 2 else 1]:
                t = servers[name].round()
                if r > 0:  # the first round warms up
                    times[name].append(t)
        for name, t in times.items():
            ratios = sorted(a / b for a, b in zip(t, times["off"]))
            print(f"{name:6} {1e6 * statistics.median(t):7.1f} us a call, {statistics.median(ratios):.3f} of off "
                  f"(middle half {ratios[len(ratios) // 4]:.3f} to {ratios[-1 - len(ratios) // 4]:.3f})")
    finally:
        for server in servers.values():
            server.end()


main()
