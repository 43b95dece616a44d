#!/usr/bin/python3
"""Writes the tables of this folder.  With --check it lists the tables that differ from what the scripts make.

Every other script here has a function tables() that yields Table objects.  Their formulas differ from those of the
tested code.
"""
import argparse
import importlib
import pathlib
import sys

here = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(here))
sys.dont_write_bytecode = True


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    stale, made = [], set()
    for script in sorted(here.glob("*.py")):
        if script.stem in ("make_tables", "table"):
            continue
        for table in importlib.import_module(script.stem).tables():
            path = table.path(here)
            made.add(path)
            if not check:
                path.write_text(table.text())
            elif not path.exists() or path.read_text() != table.text():
                stale.append(path.name)
    stale += [p.name for p in here.glob("*.txt") if p not in made]
    if stale:
        sys.exit("not what the scripts make: " + ", ".join(stale))


main()
