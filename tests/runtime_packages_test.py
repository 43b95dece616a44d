#!/usr/bin/python3
"""The packages of `deploy/install-deps.sh --runtime` are those whose libraries the programs load.

    tests/runtime_packages_test.py BUILD_DIR
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
# Every image of Debian with a C++ program has these, or a package of the list depends on them.
COMMON = {"libc6", "libgcc-s1", "libstdc++6", "libgrpc29"}


def output(*command):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, check=True).stdout


def packages_of(program):
    """The packages of the libraries that the program names itself."""
    needed = set(re.findall(r"\(NEEDED\).*\[(.+)\]", output("readelf", "-d", program)))
    paths = dict(re.findall(r"(\S+) => (/\S+)", output("ldd", program)))
    found = set()
    for path in {str(pathlib.Path(paths[name]).resolve()) for name in needed if name in paths}:
        # Debian's packages name /lib or /usr/lib; these are the same folder.
        for known in (path, path.removeprefix("/usr")):
            owner = subprocess.run(["dpkg", "-S", known], capture_output=True, text=True, check=False)
            if owner.returncode == 0:
                found.add(owner.stdout.split(":")[0])
                break
        else:
            sys.exit(f"{path}: no package has it")
    return found


def main():
    build = pathlib.Path(sys.argv[1])
    text = re.search(r"^runtime=\((.*?)^\)", (ROOT / "deploy/install-deps.sh").read_text(), re.M | re.S)[1]
    listed = set(text.split())
    pictures, = (build / "bin").glob("lucerna-pictures-*.so")
    needed = packages_of(build / "bin/lucernad") | packages_of(build / "bin/lucerna") | packages_of(pictures)
    if missing := needed - listed - COMMON:
        sys.exit(f"deploy/install-deps.sh --runtime lacks {sorted(missing)}")
    if unused := listed - needed:
        sys.exit(f"deploy/install-deps.sh --runtime has {sorted(unused)}, which no program loads")


main()
