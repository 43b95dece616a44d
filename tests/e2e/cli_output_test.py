#!/usr/bin/python3
"""The forms of answers: tables with colours on a terminal, JSON, and CSV in full precision.

    tests/e2e/cli_output_test.py BUILD_DIR
"""
import csv
import io
import json
import os
import pathlib
import pty
import re
import select
import shutil
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from server_process import ServerProcess  # noqa: E402

REFERENCE = pathlib.Path(__file__).resolve().parents[1] / "data/reference"
TIMEOUT_S = 900  # ends a test that hangs
BOLD, RED, END = "\033[1m", "\033[31m", "\033[0m"
POINT = ["--point", "0.1,0.2,0.3", "--normal", "0,0,1"]
# Each command that prints a table, with the names of its first columns in CSV.
TABLES = {
    "power": (["power", "point.pbrt"], ["id", "type", "flux [lm]", "error [lm]", "R [lm]", "G [lm]", "B [lm]"]),
    "lights": (["lights", "point.pbrt"], ["id", "type", "what", "where [m]", "area [m2]", "flux [lm]", "error [lm]"]),
    "scenes": (["scenes"], ["id", "lights", "primitives", "width [px]", "height [px]", "memory [kB]"]),
    "available": (["scenes", "--available"], ["path"]),
    "scene": (["scene", "point.pbrt"], ["part", "memory [kB]", "built in [ms]", "why"]),
    "inspect": (["inspect", "point.pbrt"], ["what", "kind", "count", "details"]),
    "leases": (["leases"], ["lease", "ends in [s]", "owner", "scene", "path"]),
    "info": (["info"], ["what", "value"]),
    "doctor": (["doctor"], ["status", "check", "result"]),
    "top": (["top", "--once"], ["call", "running", "calls/s"]),
    "sample": (["sample", "point.pbrt", *POINT],
               ["point", "light", "chosen with", "value R", "value G", "value B", "unit", "wi x", "wi y", "wi z",
                "distance [m]", "pdf [1/sr]", "status"]),
    "estimates": (["sample", "point.pbrt", *POINT, "--error", "50%"], ["x [m]", "y [m]", "z [m]"]),
    "pdf": (["pdf", "point.pbrt", *POINT, "--light", "1", "--direction", "0,0,1"],
            ["x [m]", "y [m]", "z [m]", "wi x", "wi y", "wi z", "pdf [1/sr]", "status"]),
    "emit": (["emit", "point.pbrt", "--count", "3", "--wavelength", "450,555"],
             ["light", "chosen with", "from x [m]", "from y [m]", "from z [m]", "direction x"]),
    "emit-pdf": (["emit-pdf", "point.pbrt", "--light", "1", "--point", "0,0,0", "--direction", "0,0,1"],
                 ["x [m]", "y [m]", "z [m]", "direction x", "direction y", "direction z", "pdf [1/m2]", "pdf [1/sr]"]),
    "le": (["le", "point.pbrt", "--point", "0,0,0", "--direction", "0,0,1"],
           ["x [m]", "y [m]", "z [m]", "direction x", "direction y", "direction z", "radiance R [cd/m2]"]),
    "visible": (["visible", "point.pbrt", "--point", "0,0,0", "--to", "0,0,1"],
                ["x [m]", "y [m]", "z [m]", "to x [m]", "to y [m]", "to z [m]", "visible"]),
    "irradiance": (["irradiance", "point.pbrt", *POINT, "--samples", "16"],
                   ["x [m]", "y [m]", "z [m]", "illuminance [lx]", "lower [lx]", "upper [lx]", "R [lx]", "G [lx]",
                    "B [lx]", "status"]),
    "shares": (["irradiance", "point.pbrt", *POINT, "--samples", "16", "--per-light"],
               ["light", "x [m]", "y [m]", "z [m]", "share [lx]", "lower [lx]", "upper [lx]", "status"]),
    "bench": (["bench", "empty", "--time", "100ms", "--warm-up", "10ms", "--window", "20ms"], ["in flight", "calls/s"]),
}
NO_TABLE = (["load", "point.pbrt"], ["edit", "point.pbrt", "--remove", "1"], ["lease", "point.pbrt", "--for", "9"],
            ["release", "point.pbrt"], ["render", "point.pbrt", "-o", "x.png"])


def expect(condition, message):
    if not condition:
        sys.exit(f"{message}")


class Program:
    def __init__(self, build, server, folder):
        self.path, self.server, self.folder = str(build / "bin/lucerna"), server, folder

    def environment(self, **more):
        return {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "TERM")} | {
            "LUCERNA_SERVER": self.server.target, "TERM": "xterm"} | more

    def run(self, *words):
        return subprocess.run([self.path, *words], capture_output=True, text=True, timeout=TIMEOUT_S, check=False,
                              cwd=self.folder, env=self.environment())

    def on_terminal(self, *words, **environment):
        """What a terminal gets from the program, with line ends of files."""
        pid, terminal = pty.fork()
        if pid == 0:
            os.chdir(self.folder)
            os.execvpe(self.path, [self.path, *words], self.environment(**environment))
        text = b""
        while True:
            expect(select.select([terminal], [], [], TIMEOUT_S)[0], f"{words} hangs")
            try:
                more = os.read(terminal, 65536)
            except OSError:  # the program has ended
                break
            if not more:
                break
            text += more
        os.waitpid(pid, 0)
        os.close(terminal)
        return text.decode().replace("\r\n", "\n")


def as_float(value):
    """The nearest number of 32 bits, which messages hold."""
    return struct.unpack("f", struct.pack("f", value))[0]


def read_csv(text):
    expect(text.endswith("\n"), f"CSV without a line end: {text!r}")
    rows = list(csv.reader(io.StringIO(text), strict=True))
    for row in rows:
        expect(len(row) == len(rows[0]), f"rows of different lengths:\n{text}")
    expect(len(set(rows[0])) == len(rows[0]) and all(rows[0]), f"names of columns: {rows[0]}")
    return rows[0], [dict(zip(rows[0], row)) for row in rows[1:]]


def csv_is_a_table(program):
    for name, (words, columns) in TABLES.items():
        ran = program.run(*words, "--output", "csv")
        # doctor may find a fault of this machine.
        expect(ran.returncode == 0 or name == "doctor", f"{words}: {ran.stderr}")
        header, _ = read_csv(ran.stdout)
        expect(header[:len(columns)] == columns, f"{name}: columns {header}, expected {columns}")


def csv_has_full_precision(program):
    _, rows = read_csv(program.run("power", "many_points.pbrt", "--output", "csv").stdout)
    lights = json.loads(program.run("power", "many_points.pbrt", "--output=json").stdout)["lights"]
    expect(len(rows) == len(lights) + 1 and len(lights) > 10, f"{len(rows)} rows, {len(lights)} lights")
    for row, light in zip(rows, lights):
        expect(float(row["flux [lm]"]) == light["powerLm"], f"{row}: not {light}")
        expect(float(row["G [lm]"]) == light["rgbLm"]["g"], f"{row}: not {light}")
    words = ["irradiance", "rectangle_near.pbrt", *POINT, "--samples", "64"]
    _, (row,) = read_csv(program.run(*words, "--output", "csv").stdout)
    answer = json.loads(program.run(*words, "--json").stdout)
    for column, field, item in (("illuminance [lx]", "illuminanceLx", 0), ("lower [lx]", "lowerLx", 0),
                                ("upper [lx]", "upperLx", 0), ("B [lx]", "irradianceLx", 2)):
        expect(as_float(float(row[column])) == as_float(answer[field][item]), f"{column} = {row[column]}, JSON has {answer[field][item]}")
    expect(any(len(value) > 8 for value in row.values()), f"six digits only: {row}")


def csv_quotes(program, scenes):
    name = 'a, "b".pbrt'
    shutil.copy(REFERENCE / "point.pbrt", scenes / name)
    ran = program.run("scenes", "--available", "--output", "csv")
    expect('"a, ""b"".pbrt"\n' in ran.stdout, ran.stdout)
    expect(name in [row["path"] for row in read_csv(ran.stdout)[1]], ran.stdout)


def wrong_forms(program):
    for words in NO_TABLE:
        ran = program.run(*words, "--output", "csv")
        expect(ran.returncode == 2 and ran.stdout == "" and "prints no table; allowed: table, json" in ran.stderr,
               f"{words}: {ran}")
    ran = program.run("info", "--output", "xml")
    expect(ran.returncode == 2 and "xml is not one of table, json, csv" in ran.stderr, ran)
    expect(program.run("info", "--json", "--output", "csv").returncode == 2, "--json and --output csv at once")
    expect(program.run("top", "--output", "csv").returncode == 2, "top without --once as CSV")
    ran = program.run("power", "none.pbrt", "--output", "json")
    expect(ran.returncode == 1 and "error" in json.loads(ran.stderr), ran)


def output_is_also_a_file(program):
    ran = program.run("render", "point.pbrt", "--samples", "1", "--output", "x.png", "--output", "json")
    expect(ran.returncode == 0 and "cost" in json.loads(ran.stdout), ran)
    expect((program.folder / "x.png").exists() and not (program.folder / "json").exists(), os.listdir(program.folder))


def colours(program):
    words = ["power", "point.pbrt"]
    plain = program.run(*words).stdout
    expect("\033" not in plain, f"colours in a pipe: {plain!r}")
    shown = program.on_terminal(*words)
    expect(shown.startswith(f"{BOLD}") or f" {BOLD}id{END}" in shown, f"the header is not bold: {shown!r}")
    expect(re.sub(r"\033\[\d*m", "", shown) == plain, f"colours change the alignment:\n{shown!r}\n{plain!r}")
    for environment in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        expect(program.on_terminal(*words, **environment) == plain, f"colours with {environment}")
    expect(BOLD in program.on_terminal(*words, NO_COLOR=""), "an empty NO_COLOR must not count")
    for form in ("csv", "json"):
        expect("\033" not in program.on_terminal(*words, "--output", form), f"colours in {form}")
    error = program.on_terminal("power", "none.pbrt")
    expect(error.startswith(f"{RED}lucerna:{END} "), f"the error is not red: {error!r}")
    expect("\033" not in program.run("power", "none.pbrt").stderr, "colours of an error in a pipe")
    expect("\033" not in program.on_terminal("power", "none.pbrt", "--json"), "colours of an error in JSON")


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as directory:
        folder = pathlib.Path(directory)
        scenes = folder / "scenes"
        scenes.mkdir()
        for name in ("point.pbrt", "many_points.pbrt", "rectangle_near.pbrt", "ball.ply"):
            shutil.copy(REFERENCE / name, scenes)
        with ServerProcess(build, scenes) as server:
            program = Program(build, server, folder)
            csv_is_a_table(program)
            csv_has_full_precision(program)
            csv_quotes(program, scenes)
            wrong_forms(program)
            output_is_also_a_file(program)
            colours(program)


main()
