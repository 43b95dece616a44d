#!/usr/bin/python3
"""`deploy/install-deps.sh --tests` installs every program and module without which a test is skipped, but for Blender.

    tests/test_packages_test.py
"""
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys

TESTS = pathlib.Path(__file__).resolve().parent
NOT_INSTALLED = {"blender"}


def listed():
    """The packages of the script, and what they depend on: some only name others."""
    text = (TESTS.parent / "deploy/install-deps.sh").read_text()
    names = {n for which in ("packages", "tests")
             for n in re.sub("#.*", "", re.search(rf"^{which}=\((.*?)^\)", text, re.M | re.S)[1]).split()}
    depends = subprocess.run(["dpkg-query", "-W", "-f=${Depends}, ", *names], capture_output=True, text=True,
                             check=False).stdout
    return names | set(re.findall(r"(?:^|, )([a-z0-9.+-]+)", depends))


def used():
    """Names of programs and modules, with the file that they are missed in."""
    for file in sorted(TESTS.rglob("*.py")):
        text = file.read_text()
        for kind, pattern in (("program", r'shutil\.which\("([\w-]+)"'), ("module", r'importorskip\("(\w+)"')):
            for name in re.findall(pattern, text):
                yield kind, name, file
    for name in re.search(r"foreach\(SHELL ([a-z ]+)\)", (TESTS / "e2e/CMakeLists.txt").read_text())[1].split():
        yield "program", name, TESTS / "e2e/completion_test.py"


def path_of(kind, name):
    if kind == "program":
        folders = (os.environ["PATH"], "/usr/sbin", str(TESTS.parent / "build/buf/node_modules/.bin"))
        return shutil.which(name, path=":".join(folders))
    found = importlib.util.find_spec(name)
    return found and found.origin


def owner(path):
    for known in (path, os.path.realpath(path), path.removeprefix("/usr")):
        found = subprocess.run(["dpkg", "-S", known], capture_output=True, text=True, check=False)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    return None


def main():
    packages, seen, faults = listed(), set(), []
    for kind, name, file in used():
        if name in NOT_INSTALLED or name in seen:
            continue
        seen.add(name)
        path = path_of(kind, name)
        if path is None:
            faults.append(f"{file}: the {kind} {name} is missing; `deploy/install-deps.sh --tests` installs what tests use")
            continue
        package = owner(path)
        essential = package and subprocess.run(["dpkg-query", "-W", "-f=${Essential}", package], capture_output=True,
                                               text=True, check=False).stdout == "yes"
        # A program without a package is not Debian's, such as npm of another source.
        if package and package not in packages and not essential:
            faults.append(f"{file}: {name} is of the package {package}, which deploy/install-deps.sh does not list")
    if not {"haproxy", "fish", "mypy"} <= seen:
        faults.append(f"the search finds only {sorted(seen)}")
    if faults:
        sys.exit("\n".join(faults))


main()
