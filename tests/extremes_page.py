#!/usr/bin/python3
"""Writes docs/extremes.md from the records of the sweeps of tests/{lights,server}/extremes.

    tests/extremes_page.py BUILD_DIR [--check] [--results]

Runs both test programs, or with --results reads the results of ctest in BUILD_DIR/results.  If a test fails, it writes
no page.  With --check it writes nothing, and exits with 1 if the page differs or lacks a row of ROWS.  Relative errors
are rounded up to one digit, and count as equal within a factor of two: libm uses other instructions on other processors.
"""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/extremes.md"
MUTANTS = ROOT / "tests/mutants"
PROGRAMS = ["tests/lights/extremes/lights_extremes_test", "tests/server/extremes/server_extremes_test"]
ROWS = range(1, 42)
SAME_WITHIN = 2
ROUNDING = 1e-15
MEASURED = re.compile(r"\b\de[+-]\d\d\b|\bexact\b")
CELL = re.compile(r"(?<!\\)\|")
MEASURED_COLUMNS = (5, 7)  # Lucerna's and the textbook's; the empty cell before the first column is 0

HEAD = """\
# Right at the extremes

This page lists inputs that are known to break renderers, and the accuracy of Lucerna's answers to them.

    make extremes

This command runs the tests and writes this page.  `.ci/run` fails if the page is not current.

Each line is a test that sweeps over a range of magnitudes.  These are the columns:

| column | content |
|---|---|
| row | the number of a problem; rows 13 to 17 and 19 are about choosing among many lights |
| input | the kind of input |
| swept | the magnitudes that the test sweeps over |
| figure | what the test compares with a reference |
| Lucerna | the worst relative error that occurred, or the answer in words |
| allowed | the largest relative error that the test accepts |
| textbook, in float | the worst error, or the answers, of the usual formula in floats, for the same inputs |
| test | the test, and the [mutants](../tests/mutants) of the row |

- Answers in capitals are [item statuses](api.md#item-statuses).  Other words describe what happened.
- "None of 4e+06, 1e+05 left out": none of 4e+06 cases is wrong.  1e+05 cases are left out, because floats have no right
  answer there.
- A mutant removes the fix behind a row.  `make mutants` checks that the test of the row then fails.
- References have 30 digits.  mpmath computes the tables in [tests/data/extremes](../tests/data/extremes) with 60
  digits, by other formulas than the code's.  The scripts in that folder generate the tables.  If a test says so, the
  reference is a closed form.
- Some tests compare the code with itself.  They compare densities of samples with the answers of PdfLi and PdfLe, or a
  scene with the same scene in other units.
- Figures of `tests/lights` are those of lights in double, as the server computes them.  Answers are floats.  Their
  rounding adds up to 6e-8.
- Errors are rounded up to one digit.  "Exact" means that all bits equal those of the reference.  An infinite error is
  an infinite answer, or a nonzero answer where 0 is right.

## The tests

"""


def stored_results(build):
    """Yields the tests of both programs from the reports of ctest's shards."""
    for program in PROGRAMS:
        name = pathlib.Path(program).name
        reports = sorted((build / "results").glob(f"{name}.*.json"))
        if not reports:
            sys.exit(f"extremes: no results of {name} in {build / 'results'}; run ctest first")
        for report in reports:
            if report.stat().st_mtime < (build / program).stat().st_mtime:
                sys.exit(f"extremes: {report} is older than {name}; run ctest again")
            for suite in json.loads(report.read_text())["testsuites"]:
                for test in suite["testsuite"]:
                    if "failures" in test:
                        sys.exit(f"extremes: {test['classname']}.{test['name']} failed, so there is no page")
                    yield test


def results(build):
    """Yields the tests of both programs from the reports of GoogleTest."""
    for program in PROGRAMS:
        if not (build / program).is_file():
            sys.exit(f"extremes: {build / program} does not exist, allowed: a build folder, such as build/release")
    with tempfile.TemporaryDirectory() as folder:
        reports = [pathlib.Path(folder) / f"{i}.json" for i in range(len(PROGRAMS))]
        runs = [subprocess.Popen([build / program, "--gtest_brief=1", f"--gtest_output=json:{report}"])
                for program, report in zip(PROGRAMS, reports)]
        if any([run.wait() != 0 for run in runs]):
            sys.exit("extremes: tests failed, so there is no page")
        for report in reports:
            for suite in json.loads(report.read_text())["testsuites"]:
                yield from suite["testsuite"]


def rounded_up(text):
    """Rounds an error up to one digit.  0 is "exact"."""
    value = float(text)
    if value == 0:
        return "exact"
    if math.isinf(value):
        return "infinite"
    digit, exponent = f"{value:.16e}".split("e")
    digit, exponent = math.ceil(float(digit) * (1 - 1e-12)), int(exponent)
    return f"{digit}e{exponent:+03}" if digit < 10 else f"1e{exponent + 1:+03}"


def line(test, mutants):
    """Returns a line of the table.  A test has either a figure or an answer in words."""
    served = [test["answers"]] if "answers" in test else []
    if "worst" in test:
        served.append(rounded_up(test["worst"]))
    textbook = [rounded_up(test["textbook"])] if "textbook" in test else []
    if "textbook_answers" in test:
        textbook.append(test["textbook_answers"])
    source = pathlib.Path(test["file"])
    source = source.relative_to(ROOT) if source.is_absolute() else pathlib.Path(*[p for p in source.parts if p != ".."])
    cells = [test["row"], test["input"], test["swept"], test["figure"], "; ".join(served),
             rounded_up(test["allowed"]) if "allowed" in test else "", "; ".join(textbook),
             f"[{test['classname']}.{test['name']}](../{source})" + mutants]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def page(tests):
    lines = []
    by_row = sorted((t for t in tests if "row" in t), key=lambda t: (int(t["row"]), t["classname"], t["file"], t["line"]))
    for i, test in enumerate(by_row):
        first = i == 0 or by_row[i - 1]["row"] != test["row"]
        patches = sorted(MUTANTS.glob(f"{int(test['row']):02}*.patch")) if first else []
        links = "".join(f", [{p.stem}](../tests/mutants/{p.name})" for p in patches)
        lines.append(line(test, links and "; mutants" + links[1:]))
    head = ("| row | input | swept | figure | Lucerna | allowed | textbook, in float | test |\n"
            "|---|---|---|---|---|---|---|---|\n")
    return HEAD + head + "\n".join(lines) + "\n", {int(t["row"]) for t in by_row}


def same_cell(there, made):
    """Whether two measured cells agree, figures within a factor of SAME_WITHIN.  An exact figure may have a rounding
    on another processor."""
    def figures(cell):
        return [0 if f == "exact" else float(f) for f in MEASURED.findall(cell)]
    def alike(a, b):
        return max(a, b) <= ROUNDING if min(a, b) == 0 else max(a, b) <= SAME_WITHIN * min(a, b) * (1 + 1e-9)
    return MEASURED.sub("", there) == MEASURED.sub("", made) and all(map(alike, figures(there), figures(made)))


def same(there, made):
    """Whether two pages agree: every character, except in measured figures."""
    there, made = there.splitlines(), made.splitlines()
    if len(there) != len(made):
        return False
    for a, b in zip(there, made):
        cells_a, cells_b = CELL.split(a), CELL.split(b)
        if len(cells_a) != len(cells_b):
            return False
        for column, (x, y) in enumerate(zip(cells_a, cells_b)):
            measured = a.startswith("| ") and column in MEASURED_COLUMNS
            if not (same_cell(x, y) if measured else x == y):
                return False
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--results", action="store_true")
    options = parser.parse_args()
    made, rows = page((stored_results if options.results else results)(options.build.resolve()))
    missing = [row for row in ROWS if row not in rows]
    if options.check:
        if not PAGE.exists() or not same(PAGE.read_text(), made):
            sys.exit("docs/extremes.md is not current: make extremes")
    else:
        PAGE.write_text(made)
    if missing:
        sys.exit("docs/extremes.md has no line for rows " + ", ".join(map(str, missing)))


if __name__ == "__main__":
    main()
