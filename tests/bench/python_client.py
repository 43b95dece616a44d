#!/usr/bin/python3
"""Compares the time of calls of the Python package with that of the C++ library, in turns.

    tests/bench/python_client.py BUILD_DIR [--points 8192] [--pairs 200]

Needs the target client_calls.  Both clients send the same points, in batches of at most 8192, to one server on the
loopback interface.  For each kind of call the table has the medians of the wall time of a call, the median of the
ratios Python / C++, and the same ratio of the processor time of the client.  The scene has one point light, so the
server takes little of the time.
"""
import argparse
import pathlib
import statistics
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
UP = (0.0, 0.0, 1.0)


def receivers(numpy, count):
    i = numpy.arange(count)
    columns = [-2 + 4 * (i % 128 + 0.5) / 128, -2 + 4 * (i // 128 + 0.5) / 128, numpy.full(count, 0.1)]
    return numpy.stack(columns, axis=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--points", type=int, default=8192)
    parser.add_argument("--pairs", type=int, default=200)
    options = parser.parse_args()
    sys.path.insert(0, str(options.build / "python"))
    import lucerna
    import numpy

    points = receivers(numpy, options.points)
    calls = {
        "irradiance": lambda s: s.irradiance(points, UP, samples=1, bounces=0).illuminance,
        "sample_li": lambda s: s.sample_li(points).value,
        "pdf_li": lambda s: s.pdf_li(points, UP, light=1).density,
        "le": lambda s: s.le(points, UP).radiance,
        "visible": lambda s: numpy.ones(s.visible(points, directions=UP).visible.size),
    }
    with lucerna.local(ROOT / "tests/data/reference", program=options.build / "bin/lucernad", threads=2) as server:
        scene = server.load("point.pbrt")
        with subprocess.Popen([options.build / "tests/bench/client_calls", server.target, scene.id, str(len(points))],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
            def in_cpp(name):
                other.stdin.write(name + "\n")
                other.stdin.flush()
                return [float(x) for x in other.stdout.readline().split()]

            def in_python(name):
                cpu, start = time.process_time(), time.perf_counter()
                array = calls[name](scene)
                wall = time.perf_counter() - start
                return [wall, time.process_time() - cpu, float(numpy.sum(array, dtype=float))]

            print(f"{'call':<12} {'C++ [ms]':>9} {'Python [ms]':>12} {'ratio':>6} {'processor time, ratio':>22}")
            for name in calls:
                pairs = []
                for i in range(options.pairs + 10):
                    order = (in_cpp, in_python) if i % 2 else (in_python, in_cpp)
                    results = {run: run(name) for run in order}
                    a, b = results[in_cpp], results[in_python]
                    if abs(a[2] - b[2]) > 1e-6 * max(abs(a[2]), 1):
                        sys.exit(f"{name}: the answers differ: {a[2]} and {b[2]}")
                    if i >= 10:  # the first ones build connections and caches
                        pairs.append((a, b))
                wall = [1e3 * statistics.median(p[side][0] for p in pairs) for side in (0, 1)]
                ratios = [statistics.median(b[k] / a[k] for a, b in pairs) for k in (0, 1)]
                print(f"{name:<12} {wall[0]:9.2f} {wall[1]:12.2f} {ratios[0]:6.2f} {ratios[1]:22.2f}", flush=True)
            other.stdin.close()


main()
