#!/usr/bin/python3
"""Checks that tests can fail: removes one fix after another from a copy of the sources.

    tests/mutants/run.py [NAME...]       applies each patch (all, or the named ones, such as 01), builds, and expects
                                         its test to fail
    tests/mutants/run.py --oracle        only those that the oracle must find, with the oracle as the test
    tests/mutants/run.py --apply-only    checks that all patches apply, and that each row of the page has one

A patch NN.patch (or NNx.patch) belongs to row NN and begins with

    Row NN: what the changed code does.
    Test: EXECUTABLE FILTER
    Fails by: crash                      (or timeout; only if it does not fail by an expectation)
    Found by the oracle.                 (only if it is)

A patch mNN.patch belongs to the surfaces of scenes, and eNN.patch to edits of lights.  They begin with the same lines,
but for

    Surfaces: what the changed code does.
    Edits: what the changed code does.

A patch dNN.patch belongs to the doors, limits, lanes and statistics of the server, and begins with

    Doors: what the changed code does.

Its test may be a script: "Test: tests/e2e/doors_test.py lucernad,lucerna" names the script and the programs to build.

A patch oNN.patch is one for the oracle (docs/oracle.md) and begins with

    Oracle: what the changed code does.

Exits with 1 if a mutant survives, which means that no test of FILTER fails.  A patch that does not apply or build, and a
filter that matches no test, are errors too.  The copy build/mutants is kept, so that the next run is quick.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = ROOT / "tests/mutants"
COPY = ROOT / "build/mutants"
BUILD = COPY / "build/release"
PRESET = "release"
TIMEOUT_S = 300  # of a test
# Git must not find a repository above the copy.  ccache must recognise the files of one tree in the other.
ENVIRONMENT = os.environ | {"GIT_CEILING_DIRECTORIES": str(COPY.parent), "CCACHE_BASEDIR": str(COPY), "CCACHE_NOHASHDIR": "1"}


class Mutant:
    def __init__(self, path):
        self.path, self.name, text = path, path.stem, path.read_text()
        if self.name.startswith("o"):
            row = re.match(r"(Oracle): (.+)\n", text)
        else:
            row = re.match(r"(Row \d+|Surfaces|Edits|Doors): (.+)\nTest: (\S+) (\S+)\n(?:Fails by: (crash|timeout)\n)?(Found by the oracle)?", text)
            belongs_to = {"m": "Surfaces", "e": "Edits", "d": "Doors"}.get(self.name[0]) or f"Row {self.name[:2]}"
            if row and row[1].replace("Row ", "Row 0" if len(row[1]) == 5 else "Row ") != belongs_to:
                row = None
        if not row:
            sys.exit(f"{path.relative_to(ROOT)}: does not begin with the lines that run.py describes")
        self.about, self.fails_by = row[2], "expectation"
        if self.name.startswith("o"):
            self.is_for_oracle = True
            self.use_oracle()
        else:
            self.executable, self.filter, self.fails_by = row[3], row[4], row[5] or self.fails_by
            self.is_for_oracle = row[6] is not None
        self.files = re.findall(r"^\+\+\+ b/(.+)$", text, re.M)
        if not self.files or any(not f.startswith(("client/", "lights/", "server/", "proto/")) for f in self.files):
            sys.exit(f"{path.relative_to(ROOT)}: changes {self.files}, not only client, lights, server and proto")

    @property
    def is_script(self):
        return self.executable.endswith(".py")

    @property
    def targets(self):
        return self.filter.split(",") if self.is_script else [self.executable]

    def use_oracle(self):
        self.executable, self.filter, self.fails_by = "oracle_test", "Oracle.AgreesWithTheServer", "expectation"


def run(*command, **options):
    return subprocess.run(command, env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)


def refresh_copy():
    """Copies the current sources, committed or not; unchanged files keep their time."""
    def names(*options):
        return subprocess.check_output(["git", "ls-files", "-z", *options], cwd=ROOT, text=True).split("\0")[:-1]
    sources = {n for n in names("-c", "-o", "--exclude-standard") if (ROOT / n).is_file()}
    for name in sources:
        there, here = COPY / name, (ROOT / name).read_bytes()
        if there.is_file() and there.read_bytes() == here:
            continue
        there.parent.mkdir(parents=True, exist_ok=True)
        there.write_bytes(here)
        there.chmod((ROOT / name).stat().st_mode)
    for path in COPY.rglob("*"):
        name = path.relative_to(COPY)
        if path.is_file() and name.parts[0] != "build" and str(name) not in sources:
            path.unlink()


def build(targets):
    made = run("cmake", "--build", "--preset", PRESET, "--target", *targets, cwd=COPY)
    return "" if made.returncode == 0 else made.stdout[-3000:]


def outcome_of_script(mutant):
    # Scripts that test one program get its path, the others the folder of the build.
    last = BUILD / "bin" / mutant.targets[0] if len(mutant.targets) == 1 else BUILD
    try:
        done = run("/usr/bin/python3", COPY / mutant.executable, last, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return "timeout"
    return "passes" if done.returncode == 0 else "expectation"


def outcome(mutant):
    """The result of the mutant's test in the current copy: passes, the kind of failure, or an error."""
    if mutant.is_script:
        return outcome_of_script(mutant)
    found = [p for p in BUILD.glob(f"tests/**/{mutant.executable}") if p.is_file()]
    report = BUILD / "mutant.json"
    report.unlink(missing_ok=True)
    try:
        done = run(found[0], f"--gtest_filter={mutant.filter}", f"--gtest_output=json:{report}", timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return "timeout"
    if done.returncode < 0:
        return "crash"
    if not report.exists() or json.loads(report.read_text())["tests"] == 0:
        return f"{mutant.filter} matches no test"
    return "passes" if done.returncode == 0 else "expectation"


def judge(mutant):
    """Applies the patch, builds, runs the test, reverts; "killed", or an error."""
    applied = run("git", "apply", mutant.path, cwd=COPY)
    if applied.returncode != 0:
        return "does not apply: " + applied.stdout
    try:
        error = build(mutant.targets)
        if error:
            return "does not build: " + error
        now = outcome(mutant)
        if now == mutant.fails_by:
            return "killed"
        return "SURVIVED" if now == "passes" else f"fails by {now}, not by {mutant.fails_by}"
    finally:
        run("git", "apply", "--reverse", mutant.path, cwd=COPY, check=True)


def run_mutants(mutants):
    refresh_copy()
    if not (BUILD / "build.ninja").exists():
        run("cmake", "--preset", PRESET, cwd=COPY, check=True)
    for targets in sorted({tuple(m.targets) for m in mutants}):
        if error := build(targets):
            sys.exit(f"{', '.join(targets)}: {error}")
    # Run all tests first, because later the executables are those of the previous mutant.
    before = {(m.executable, m.filter): outcome(m)
              for m in {(m.executable, m.filter): m for m in mutants}.values()}
    good = True
    for m in mutants:
        start = time.monotonic()
        was = before[m.executable, m.filter]
        verdict = judge(m) if was == "passes" else f"without the mutant: {was}"
        good &= verdict == "killed"
        print(f"{m.name:4} {time.monotonic() - start:5.0f} s  {verdict:8}  {m.filter}: {m.about}", flush=True)
    print(f"{len(mutants)} mutants" + (", all killed" if good else ""))
    return good


def check(mutants):
    """Checks without a build that all patches apply, and that each row of the page has one."""
    good = True
    for m in mutants:
        applied = run("git", "apply", "--check", m.path, cwd=ROOT)
        if applied.returncode != 0:
            good = False
            print(f"{m.name} does not apply: {applied.stdout}")
    page = ROOT / "docs/extremes.md"
    rows = set(re.findall(r"^\| (\d+) \|", page.read_text(), re.M))
    for row in sorted(int(r) for r in rows if not list(HERE.glob(f"{int(r):02}*.patch"))):
        good = False
        print(f"row {row} of docs/extremes.md has no mutant")
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--apply-only", action="store_true")
    parser.add_argument("--oracle", action="store_true")
    options = parser.parse_args()
    mutants = [Mutant(p) for p in sorted(HERE.glob("*.patch")) if not options.names or p.stem in options.names]
    if unknown := set(options.names) - {m.name for m in mutants}:
        sys.exit("no such mutants: " + ", ".join(sorted(unknown)))
    if options.oracle:
        mutants = [m for m in mutants if m.is_for_oracle]
        if not mutants:
            sys.exit("none of these mutants is for the oracle")
        for m in mutants:
            m.use_oracle()
    sys.exit(0 if (check if options.apply_only else run_mutants)(mutants) else 1)


if __name__ == "__main__":
    main()
