#!/usr/bin/python3
"""Measures the irradiance of many points, from a file into a file: time, and the client's memory.

    tests/bench/receivers.py BUILD_DIR [--points 1000000,10000000]

The scene is a floor under one point light with direct light only, so this measures the path of the
points, not the light.  A job with more to compute has fewer points per second and no more memory.
The files of 10^7 points take half a gigabyte.  Needs python3-numpy.
"""
import argparse
import pathlib
import re
import signal
import subprocess
import tempfile
import time

import numpy as np

SCENE = """WorldBegin
LightSource "point" "rgb I" [10 10 10] "point3 from" [0 0 2]
Shape "bilinearmesh" "point3 P" [-4 -4 0  4 -4 0  -4 4 0  4 4 0]
"""
DEADLINE_S = 600  # of a single job
ROWS = 1 << 20  # rows per write


class Server:
    def __init__(self, build, root):
        self.process = subprocess.Popen(
            [str(build / "bin/lucernad"), "--scene-root", str(root), "--threads", "1",
             "--listen", "127.0.0.1:0"],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        line = self.process.stdout.readline()
        match = re.match(r"listening on (\S+)", line)
        if not match:
            raise RuntimeError(f"lucernad did not start: {line!r}")
        self.target = match[1]

    def stop(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


def write_points(path, count):
    """Points on the floor with normals: float32, six columns."""
    points = np.lib.format.open_memmap(path, mode="w+", dtype="<f4", shape=(count, 6))
    random = np.random.default_rng(1)
    for first in range(0, count, ROWS):
        rows = points[first:first + ROWS]
        rows[:, :2] = random.uniform(-3, 3, (len(rows), 2))
        rows[:, 2:] = [0, 0, 0, 1]
    points.flush()


def check(points_path, results_path):
    """Illuminance by the closed form I cos / d^2, where the cosine is 2 / d."""
    points, results = np.load(points_path, mmap_mode="r"), np.load(results_path, mmap_mode="r")
    for first in range(0, len(points), ROWS):
        at = points[first:first + ROWS].astype(np.float64)
        expected = 10 * 2 / (at[:, 0]**2 + at[:, 1]**2 + 4)**1.5
        if not np.allclose(results[first:first + ROWS, 0], expected, rtol=2e-6, atol=0):
            raise SystemExit(f"{results_path}: not the closed form")


def peak_megabytes(process):
    """The largest resident set so far; 0 after the process has ended."""
    try:
        status = pathlib.Path(f"/proc/{process}/status").read_text()
    except OSError:
        return 0.0
    match = re.search(r"VmHWM:\s+(\d+) kB", status)
    return int(match[1]) * 1024 / 1e6 if match else 0.0


def run(build, points, output, servers, halt=None):
    """Time [s], and the client's largest resident set [MB].  `halt`: a server to halt meanwhile."""
    journal = output.with_suffix(".journal")
    begun = time.monotonic()
    process = subprocess.Popen(
        [str(build / "bin/lucerna"), "irradiance", "floor.pbrt", "--points", str(points), "-o",
         str(output), "--servers", ",".join(s.target for s in servers), "--bounces", "0",
         "--samples", "1", "--journal", str(journal), "--timeout", str(DEADLINE_S)],
        stdout=subprocess.DEVNULL)
    peak = 0.0
    while process.poll() is None:
        # Not ru_maxrss, which starts with the memory of this process.
        peak = max(peak, peak_megabytes(process.pid))
        if halt and journal.exists() and journal.stat().st_size > 200:
            halt.process.send_signal(signal.SIGSTOP)
            halt = None
        time.sleep(0.005)
    if process.returncode != 0:
        raise SystemExit(f"lucerna ended with {process.returncode}")
    if halt:
        raise SystemExit("the job was over before a server could be halted")
    return time.monotonic() - begun, peak


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--points", default="1000000,10000000")
    options = parser.parse_args()
    build = options.build.resolve()
    print("| points | servers of one thread | s | points/s | client's largest resident set [MB] |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        scratch = pathlib.Path(name)
        (scratch / "floor.pbrt").write_text(SCENE)
        for count in map(int, options.points.split(",")):
            points = scratch / "points.npy"
            write_points(points, count)
            for what in ["1", "2", "2, one halted at once"]:
                servers = [Server(build, scratch) for _ in range(int(what[0]))]
                try:
                    output = scratch / "light.npy"
                    halt = servers[-1] if "halted" in what else None
                    seconds, megabytes = run(build, points, output, servers, halt)
                finally:
                    for server in servers:
                        server.stop()
                check(points, output)
                print(f"| {count} | {what} | {seconds:.2f} | {count / seconds:.3g} |"
                      f" {megabytes:.0f} |", flush=True)


if __name__ == "__main__":
    main()
