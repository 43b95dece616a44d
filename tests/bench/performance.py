#!/usr/bin/python3
"""Measures the speed targets, and prints target, figure and ratio side by side.

    tests/bench/performance.py BUILD_DIR [ROW ...] [--page docs/performance.md]

Without ROW, all rows.  Each row runs one program, which compares two things in turns and prints a median.  With --page
it also writes the table into that page, between the lines `<!-- table -->` and `<!-- end -->`.
"""
import argparse
import os
import pathlib
import re
import resource
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/e2e"))
from server_process import ServerProcess  # noqa: E402

TIMEOUT_S = 3600  # ends programs that hang
STARTS = 21
RENDERS = 3
ANSWERS = 5
EMBREE_MODELS = pathlib.Path("/usr/share/doc/embree3/models")
# The processor time of `irradiance` before paths drew their lights and kept a small weight [s], on the machine of
# docs/performance.md.
IRRADIANCE_BEFORE_S = 4.84


class Bench:
    """Runs the programs of a build, each command once."""

    def __init__(self, build):
        self.build = build
        self.outputs = {}

    def output(self, command):
        if command not in self.outputs:
            words = command.split()
            done = subprocess.run([self.build / "tests/bench" / words[0], *words[1:]], capture_output=True, text=True,
                                  timeout=TIMEOUT_S, check=False)
            if done.returncode != 0:
                raise RuntimeError(f"{command}: {done.stderr}")
            self.outputs[command] = done.stdout
        return self.outputs[command]

    def ratio(self, command, pattern):
        """The number after `pattern`, and both sides of its row."""
        match = re.search(pattern, self.output(command))
        if not match:
            raise RuntimeError(f"{command}: no line {pattern}")
        return match.groups()

    def processor_ms(self, *arguments):
        """Median processor time of `lucerna ARGUMENTS` [ms]."""
        times = []
        for _ in range(STARTS):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([self.build / "bin/lucerna", *arguments], stdout=subprocess.DEVNULL, check=True,
                           timeout=TIMEOUT_S)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        return 1e3 * statistics.median(times)


def wire(name, target):
    def measure(bench):
        ours, least, ratio = bench.ratio(f"wire_bench 5 {name}", rf"{name}[^\n]*?\s([\d.e+]+)\s+([\d.e+]+)\s+([\d.]+)\n")
        return f"{float(ours):.3g} of {float(least):.3g} /s", float(ratio), float(ratio) >= target
    return measure


def visibility(order, exact, target):
    def measure(bench):
        embree, plain, plain_ratio, with_error, error_ratio = bench.ratio(
            "visibility_bench 5",
            rf"{order}\s+Embree\s+([\d.]+) Mray/s; server\s+([\d.]+), ([\d.]+) times; "
            rf"position_error_m 0:\s+([\d.]+), ([\d.]+) times")
        ours, ratio = (with_error, error_ratio) if exact else (plain, plain_ratio)
        return f"{ours} of {embree} Mray/s", float(ratio), float(ratio) >= target
    return measure


def visibility_row(order, exact, target):
    how = ", `position_error_m` 0" if exact else ""
    return (f"TestVisibility, {order} segments{how}", f"a bare loop of `rtcOccluded1`: at least {target} times",
            "visibility_bench 5", visibility(order, exact, target))


def load(bench):
    out = bench.output("load_bench 9")
    rows = [[float(x) for x in line.split()] for line in out.splitlines()[1:-1]]
    ratio = float(out.split()[-1])
    server, hand = (statistics.median(column) for column in list(zip(*rows))[:2])
    return f"{server:.2f} of {hand:.2f} s", ratio, ratio <= 1.5


def paths(bench):
    """Millions of rays for each second of the processor: `path_bench`, and Embree's `pathtracer`, in turns."""
    ours, embree = [], []
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "embree_cornell.pbrt"
        scene.write_text(subprocess.run([ROOT / "tests/bench/embree_cornell.py"], capture_output=True, text=True,
                                        check=True, timeout=TIMEOUT_S).stdout)
        for _ in range(RENDERS):
            out = subprocess.run([bench.build / "tests/bench/path_bench", scene, "16", "1"], capture_output=True,
                                 text=True, check=True, timeout=TIMEOUT_S).stdout
            ours.append(float(re.match(r"([\d.]+) Mray/s", out)[1]))
            embree.append(embree_paths())
    ratio = statistics.median(ours) / statistics.median(embree)
    return f"{statistics.median(ours):.2f} of {statistics.median(embree):.2f} Mray/s", ratio, ratio >= 0.8


def embree_paths():
    """Millions of rays for each second of the processor that Embree's `pathtracer` traces."""
    warm_up, frames = 1, 4
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    out = subprocess.run(
        ["pathtracer", "-c", "cornell_box.ecs", "--size", "512", "512", "--spp", "16", "--benchmark", str(warm_up),
         str(frames)], cwd=EMBREE_MODELS, capture_output=True, text=True, check=True, timeout=TIMEOUT_S).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    rate, pictures = (float(re.search(rf"BENCHMARK_RENDER_{name} ([\d.]+)", out)[1]) for name in ("MRAYPS_AVG", "AVG"))
    return rate / pictures * (warm_up + frames) / (after.ru_utime - before.ru_utime)


def equal_error(name, target):
    def measure(bench):
        times, = bench.ratio("equal_error_bench", rf"\nlights: [^\n]*{name} ([\d.]+)")
        return f"{times} of {target} times", float(times) / target, float(times) >= target
    return measure


def irradiance(bench):
    """Processor time of 325 points in an office to an error of 1%, with all reflections."""
    times = []
    with tempfile.TemporaryDirectory() as folder:
        points = pathlib.Path(folder) / "points.csv"
        points.write_text("".join(f"{0.5 + 0.25 * i},{0.5 + 0.25 * j},0.8,0,0,1\n"
                                  for j in range(13) for i in range(25)))
        with ServerProcess(bench.build, ROOT / "tests/bench", "--load", "office.pbrt") as server:
            for _ in range(ANSWERS):
                answer = server.ask("irradiance", "office.pbrt", "--points", points, "--error", "1%")
                times.append(answer["cost"]["cpuTimeS"])
    target = IRRADIANCE_BEFORE_S / 3
    figure = statistics.median(times)
    return f"{figure:.2f} of {target:.2f} s", figure / target, figure <= target


def version(bench):
    ms = bench.processor_ms("--version")
    return f"{ms:.0f} of 20 ms", ms / 20, ms <= 20


def one_point(bench):
    with ServerProcess(bench.build, ROOT / "scenes", "--load", "demo.pbrt") as server:
        ms = bench.processor_ms("--server", server.target, "irradiance", "demo.pbrt", "--point", "0,0,0", "--normal",
                                "0,0,1", "--samples", "16")
    return f"{ms:.0f} of 40 ms", ms / 40, ms <= 40


def lights(bench):
    return [line.split() for line in bench.output("many_lights_bench 10").splitlines()[1:]]


def lights_time(bench):
    """The growth of the time from 1e3 to 1e6 lights, against that of the logarithm."""
    rows = lights(bench)
    growth = float(rows[-1][1]) / float(rows[0][1])
    return f"{rows[0][1]} to {rows[-1][1]} ns", growth, growth <= 2


def lights_error(bench):
    error = next(float(row[5]) for row in lights(bench) if row[0] == "100000")
    return f"{error:.3g} of uniform's error", error, error <= 1 / 3


ROWS = {
    "random": visibility_row("random", False, 1.0),
    "coherent": visibility_row("coherent", False, 0.8),
    "random_exact": visibility_row("random", True, 1.2),
    "coherent_exact": visibility_row("coherent", True, 0.95),
    "paths": ("paths in Embree's Cornell box, one core", "Embree's `pathtracer`: at least 0.8 times",
              "path_bench embree_cornell.pbrt 16", paths),
    "error_least": ("time to equal error, 21 scenes of lights, the least", "pbrt-v4: at least 3 times faster",
                    "equal_error_bench", equal_error("least", 3)),
    "error_mean": ("the same, geometric mean", "pbrt-v4: at least 8 times faster", "equal_error_bench",
                   equal_error("geometric mean", 8)),
    "irradiance": ("irradiance of 325 points with all reflections at 1%, processor time", "a third of the time before",
                   "lucerna irradiance office.pbrt --points FILE --error 1%", irradiance),
    "point": ("SampleLi over loopback, a point light", "an echo of the same bytes: at least 0.8 times",
              "wire_bench 5 point", wire("point", 0.8)),
    "sphere": ("SampleLi over loopback, a spherical light", "an echo of the same bytes: at least 0.5 times",
               "wire_bench 5 sphere", wire("sphere", 0.5)),
    "rectangle": ("SampleLi over loopback, a rectangular light", "an echo of the same bytes: at least 0.5 times",
                  "wire_bench 5 rectangle", wire("rectangle", 0.5)),
    "tile": ("RenderTile, a picture in tiles over loopback", "the same render in process: at least 0.97 times",
             "wire_bench 5 tile", wire("tile", 0.97)),
    "load": ("loading a PLY of a million triangles", "its bytes and Embree's build: at most 1.5 times",
             "load_bench 9", load),
    "version": ("`lucerna --version`, processor time", "at most 20 ms", "lucerna --version", version),
    "one_point": ("`lucerna irradiance` of one point, processor time", "at most 40 ms",
                  "lucerna irradiance demo.pbrt --point 0,0,0 --normal 0,0,1 --samples 16", one_point),
    "lights_time": ("time of a sample, 1e3 to 1e6 lights", "grows at most as the logarithm: 2 times",
                    "many_lights_bench 10", lights_time),
    "lights_error": ("error at equal time, 1e5 lights", "at most a third of uniform choice", "many_lights_bench 10",
                     lights_error),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("rows", nargs="*", metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--page", type=pathlib.Path)
    arguments = parser.parse_args()
    if unknown := set(arguments.rows) - set(ROWS):
        parser.error(f"no row {', '.join(sorted(unknown))}, allowed: {', '.join(ROWS)}")
    for name in [n for n in os.environ if n.startswith("LUCERNA")]:
        del os.environ[name]
    bench = Bench(arguments.build.resolve())
    lines = ["| what | target | figure | ratio | met | program |", "|---|---|---|---|---|---|"]
    for line in lines:
        print(line)
    for row in arguments.rows or ROWS:
        what, target, program, measure = ROWS[row]
        figure, ratio, met = measure(bench)
        lines.append(f"| {what} | {target} | {figure} | {ratio:.3g} | {'yes' if met else 'no'} | `{program}` |")
        print(lines[-1], flush=True)
    if arguments.page:
        text = arguments.page.read_text()
        head, rest = text.split("<!-- table -->\n", 1)
        tail = rest.split("<!-- end -->", 1)[1]
        arguments.page.write_text(head + "<!-- table -->\n" + "\n".join(lines) + "\n<!-- end -->" + tail)


if __name__ == "__main__":
    main()
