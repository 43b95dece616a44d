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
ROWS = range(1, 44)
SAME_WITHIN = 2
ROUNDING = 1e-15
MEASURED = re.compile(r"\b\de[+-]\d\d\b|\bexact\b")
CELL = re.compile(r"(?<!\\)\|")
MEASURED_COLUMNS = (5, 7)  # Lucerna's and the textbook's; the empty cell before the first column is 0

HEAD = """\
# Right at the extremes

This page lists inputs that are known to break renderers, and the accuracy of Lucerna's answers to them.  This command
runs the tests and writes the page:

    make extremes

`.ci/run` fails if the page is not current.

## The problems

Each problem has a number.  It is the first column of the table of tests.

| row | problem |
|---|---|
| 1, 2 | spheres that are far away; receivers just outside or inside of spheres |
| 3 to 6 | lights that fill the hemisphere, and lights of tiny solid angles |
| 7, 8 | receivers on a light, in its plane, or with a horizon that cuts it |
| 9 | scenes of any size and in any unit |
| 10 to 12 | spots and suns of any angle |
| 13 to 17, 19 | the choice among many lights |
| 18 | power or illuminance that a scene file requests |
| 20, 21 | directions at the seams, poles and texel edges of pictures; pictures with one bright texel |
| 22, 23 | rays that leak through surfaces or hit their own surface |
| 24 | sums of many samples |
| 25 to 27 | almost equal directions, tilted shading normals, mirrors |
| 28, 29 | scaled lights; power |
| 30 | closed boxes of lights |
| 31, 32 | luminaire files and pictures with extreme or invalid values |
| 33 | sample values at the ends of their range; densities of reported samples |
| 34, 35 | degenerate triangles, empty scenes |
| 36 | grounds that are much larger than the scene |
| 37, 38 | intervals when few samples find the light |
| 39, 40 | segments in the plane of a surface; light that grazes the receiver |
| 41 | media and thin panes |
| 42 | lamps on surfaces; small lamps behind narrow obstacles |
| 43 | light by way of mirrors |

## The columns

Each line of the table of tests is a test that sweeps over a range of magnitudes:

| column | content |
|---|---|
| row | the number of the problem |
| input | the kind of input |
| swept | the magnitudes that the test sweeps over |
| figure | the quantity that the test compares with a reference |
| Lucerna | the largest relative error that occurred, or the answer in words |
| allowed | the largest relative error that the test accepts |
| textbook, in float | the largest error, or the answers, of the usual formula in floats for the same inputs |
| test | the test, and the [mutants](../tests/mutants) of the row |

- Errors are rounded up to one digit.  "Exact" means that all bits equal those of the reference.  An infinite error is
  an infinite answer, or a nonzero answer where 0 is right.
- Answers in capitals are [item statuses](api.md#item-statuses).  Other words describe what happened.
- Some tests count wrong answers.  "None of 4e+06, 1e+05 left out" means that none of 4e+06 cases is wrong.  Another
  1e+05 cases are left out, because floats have no right answer there.  In the column of the textbook, the number of
  wrong cases stands alone.
- A mutant removes the fix behind a row.  `make mutants` checks that the test of the row then fails.
- References have 30 digits.  mpmath computes them with 60 digits, by other formulas than the code's.
  [tests/data/extremes](../tests/data/extremes) has the tables and the scripts that generate them.
- An input that ends with ", closed form" has an answer that Lucerna computes without samples.  "; closed form" means
  that the reference is a formula in the test instead of a table.
- Some tests compare the code with itself.  They compare densities of samples with the answers of PdfLi and PdfLe, or a
  scene with the same scene in other units.
- Tests in `tests/lights` measure lights in double precision, as the server computes them.  The server's answers are
  floats.  Their rounding adds up to 6e-8.

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
        mutants = sorted(MUTANTS.glob(f"{int(test['row']):02}*.mutant")) if first else []
        links = "".join(f", [{p.stem}](../tests/mutants/{p.name})" for p in mutants)
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
