#!/usr/bin/python3
"""Checks that tests can fail: removes one fix after another from a copy of the sources.

    tests/mutants/run_mutants.py [NAME...]       puts in each mutant (all, or the named ones, such as 01), builds, and
                                                 expects its test to fail
    tests/mutants/run_mutants.py --oracle        only those that the oracle must find, with the oracle as the test
    tests/mutants/run_mutants.py --others        names the other tests of its program that fail too
    tests/mutants/run_mutants.py --apply-only    checks that all mutants apply, and that each row of the page has one

A mutant is a text file:

    Row 1: what the changed code does.
    Test: EXECUTABLE FILTER
    Fails by: crash                      (or timeout; only if it does not fail by an expectation)
    Found by the oracle.                 (only if it is)

    File: lights/shapes/shape.cpp
     a line that stays
    -the old line
    +the new line

- NN.mutant and NNx.mutant belong to row NN of docs/extremes.md.  Others begin with "Mutant:" instead of "Row NN:".
- Without "Test:" the oracle (docs/oracle.md) is the test.  A test may be a script: "Test: tests/e2e/doors_test.py
  lucernad,lucerna" names the script and the programs to build.
- An empty line separates two changes of a file.  The lines that stay and the old lines of a change must occur exactly
  once in the file.  White space, line ends and comments do not count, so a mutant survives a new layout.

Exits with 1 if a mutant survives, which means that no test of FILTER fails.  A mutant that does not apply or build, and
a filter that matches no test, are errors too.  The copy build/mutants is kept, so that the next run is quick.
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
# ccache must recognise the files of one tree in the other.
ENVIRONMENT = os.environ | {"CCACHE_BASEDIR": str(COPY), "CCACHE_NOHASHDIR": "1"}
ORACLE = "oracle_test", "Oracle.AgreesWithTheServer"

HEAD = re.compile(r"(?:Row (\d+)|Mutant): (.+)\n"
                  r"(?:Test: (\S+) (\S+)\n)?(?:Fails by: (crash|timeout)\n)?(Found by the oracle\.\n)?\n")
# Comments, string literals (clang-format may split one in two), numbers, words, other characters.
TOKEN = re.compile(r"//[^\n]*|/\*.*?\*/|" r'"(?:\\.|[^"\\])*"(?:\s*"(?:\\.|[^"\\])*")*|' r"'(?:\\.|[^'\\])+'|"
                   r"\d[\w.']*|\w+|\S", re.S)


def tokens(text):
    """Returns the tokens of C++ text without comments, each with its place."""
    return [(re.sub(r'"\s+"', "", m[0]), m.start(), m.end())
            for m in TOKEN.finditer(text) if not m[0].startswith(("//", "/*"))]


def places(text, old):
    """Yields the start and end of each occurrence of the tokens of `old` in `text`."""
    there, wanted = tokens(text), [t[0] for t in tokens(old)]
    words = [t[0] for t in there]
    for i in range(len(words) - len(wanted) + 1):
        if words[i:i + len(wanted)] == wanted:
            yield there[i][1], there[i + len(wanted) - 1][2]


class Mutant:
    def __init__(self, path):
        self.path, self.name, text = path, path.stem, path.read_text()
        head = HEAD.match(text)
        if not head or head[1] != (str(int(self.name[:2])) if self.name[0].isdigit() else None):
            sys.exit(f"{path.relative_to(ROOT)}: does not begin with the lines that run_mutants.py describes")
        self.about, self.fails_by = head[2], head[5] or "expectation"
        self.executable, self.filter = (head[3], head[4]) if head[3] else ORACLE
        self.is_for_oracle = not head[3] or head[6] is not None
        self.changes = []  # (file, old, new)
        for file, changes in re.findall(r"^File: (.+)\n((?:[-+ ].*\n|\n)+)", text[head.end():], re.M):
            for change in filter(None, re.split(r"\n\n+", changes.strip("\n"))):
                lines = change.split("\n")
                old, new = ("\n".join(line[1:] for line in lines if line[0] in signs) for signs in ("- ", "+ "))
                self.changes.append((file, old, new.lstrip()))
        if not self.changes or any(not f.startswith(("client/", "lights/", "server/", "proto/")) for f, *_ in self.changes):
            sys.exit(f"{path.relative_to(ROOT)}: must change files of client, lights, server and proto")

    def changed_files(self, root):
        """Returns the changed text of each file below `root`.  Raises ValueError if the mutant does not apply."""
        edits = {}
        for file, old, new in self.changes:
            text = (root / file).read_text() if (root / file).is_file() else ""
            found = list(places(text, old))
            if len(found) != 1:
                raise ValueError(f"{file} has these lines {len(found)} times, not once:\n{old}")
            edits.setdefault(file, (text, []))[1].append((*found[0], new))
        for file, (text, replacements) in edits.items():
            for start, end, new in sorted(replacements, reverse=True):
                text = text[:start] + new + text[end:]
            edits[file] = text
        return edits

    @property
    def is_script(self):
        return self.executable.endswith(".py")

    @property
    def targets(self):
        return self.filter.split(",") if self.is_script else [self.executable]

    def use_oracle(self):
        (self.executable, self.filter), self.fails_by = ORACLE, "expectation"


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


def others(mutant):
    """The tests of the mutant's program, other than its own, that fail in the current copy."""
    program = next(p for p in BUILD.glob(f"tests/**/{mutant.executable}") if p.is_file())
    try:
        done = run(program, "--gtest_brief=1", f"--gtest_filter=*-{mutant.filter}", timeout=4 * TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return ["a test that takes too long"]
    if done.returncode < 0:
        return ["a test that crashes"]
    return sorted(set(re.findall(r"^\[  FAILED  \] ([\w./]+)", done.stdout, re.M)))


def judge(mutant, with_others=False):
    """Puts in the mutant, builds, runs the test, takes it out; "killed", or an error."""
    try:
        changed = mutant.changed_files(COPY)
    except ValueError as error:
        return f"does not apply: {error}"
    before = {file: (COPY / file).read_bytes() for file in changed}
    try:
        for file, text in changed.items():
            (COPY / file).write_text(text)
        error = build(mutant.targets)
        if error:
            return "does not build: " + error
        now = outcome(mutant)
        if now == mutant.fails_by:
            also = others(mutant) if with_others and not mutant.is_script else []
            return "killed" + (", also by " + " ".join(also) if also else "")
        return "SURVIVED" if now == "passes" else f"fails by {now}, not by {mutant.fails_by}"
    finally:
        for file, text in before.items():
            (COPY / file).write_bytes(text)


def run_mutants(mutants, with_others):
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
        verdict = judge(m, with_others) if was == "passes" else f"without the mutant: {was}"
        good &= verdict.startswith("killed")
        print(f"{m.name:4} {time.monotonic() - start:5.0f} s  {verdict:8}  {m.filter}: {m.about}", flush=True)
    print(f"{len(mutants)} mutants" + (", all killed" if good else ""))
    return good


def check(mutants):
    """Checks without a build that all mutants apply, and that each row of the page has one."""
    good = True
    for m in mutants:
        try:
            m.changed_files(ROOT)
        except ValueError as error:
            good = False
            print(f"{m.name} does not apply: {error}")
    page = ROOT / "docs/extremes.md"
    rows = set(re.findall(r"^\| (\d+) \|", page.read_text(), re.M))
    for row in sorted(int(r) for r in rows if not list(HERE.glob(f"{int(r):02}*.mutant"))):
        good = False
        print(f"row {row} of docs/extremes.md has no mutant")
    return good


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("--apply-only", action="store_true")
    parser.add_argument("--oracle", action="store_true")
    parser.add_argument("--others", action="store_true")
    options = parser.parse_args()
    mutants = [Mutant(p) for p in sorted(HERE.glob("*.mutant")) if not options.names or p.stem in options.names]
    if unknown := set(options.names) - {m.name for m in mutants}:
        sys.exit("no such mutants: " + ", ".join(sorted(unknown)))
    if options.oracle:
        mutants = [m for m in mutants if m.is_for_oracle]
        if not mutants:
            sys.exit("none of these mutants is for the oracle")
        for m in mutants:
            m.use_oracle()
    sys.exit(0 if (check(mutants) if options.apply_only else run_mutants(mutants, options.others)) else 1)


if __name__ == "__main__":
    main()
