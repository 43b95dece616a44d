#!/usr/bin/python3
"""Checks the manual pages: each command has one, with all its options, and man draws it without a warning.

    tests/e2e/manual_test.py BUILD_DIR
"""
import gzip
import os
import pathlib
import re
import shutil
import subprocess
import sys

TIMEOUT_S = 600  # ends a program that hangs


def run(*command, **keywords):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=TIMEOUT_S, check=False, **keywords)


def faults(build):
    programs = {"lucernad.8": ["lucernad"], "lucerna.1": ["lucerna"], "lucerna-tradeoff.1": ["lucerna-tradeoff"]}
    text = run(build / "bin/lucerna", "--help").stdout
    commands = re.findall(r"^  ([a-z-]+) ", text.split("\nSubcommands:")[1].split("\n\n")[0], re.M)
    if len(commands) < 20:
        yield f"the help lists {len(commands)} commands, expected 20 or more"
    for command in commands:
        programs.setdefault(f"lucerna-{command}.1", ["lucerna", command])
    pages = {path.name.removesuffix(".gz") for path in (build / "manual").glob("*.gz")}
    if pages != programs.keys():
        yield f"pages {sorted(pages ^ programs.keys())} are missing or of no program"
    for page in sorted(pages & programs.keys()):
        program, *command = programs[page]
        roff = gzip.open(build / "manual" / f"{page}.gz", "rt").read()
        for option in re.findall(r"^  (?:-\w,)?(--[a-z-]+)", run(build / "bin" / program, *command, "--help").stdout, re.M):
            if "\\fB" + option.replace("-", "\\-") + "\\fR" not in roff and not option.startswith("--preview"):
                yield f"{page} lacks {option}"
        for cli11 in ("UINT", "FLOAT", "TEXT:", "Needs:", "Excludes:", "REQUIRED", "(Env:"):
            if cli11 in roff:
                yield f"{page} has {cli11}, a word of CLI11"
        if shutil.which("man") is None:
            continue
        # As lintian calls it.
        drawn = run("man", "--warnings", "-E", "UTF-8", "-l", "-Tutf8", "-Z", build / "manual" / f"{page}.gz",
                    env=os.environ | {"LC_ALL": "C.UTF-8", "MANROFFSEQ": "", "MANWIDTH": "80"})
        if drawn.returncode != 0 or drawn.stderr:
            yield f"{page}: {drawn.stderr}"


found = list(faults(pathlib.Path(sys.argv[1])))
print("\n".join(found))
sys.exit(1 if found else 0)
