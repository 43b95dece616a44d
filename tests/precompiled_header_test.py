#!/usr/bin/env python3
"""A precompiled header follows the headers in it, also when ccache answers.

Builds a small project with the function lucerna_precompile and the launcher of the root's CMakeLists.txt.  The header
changes from A to B.  A fresh build folder then gets A from the cache, and the header changes to C.  Last, only a comment
of the header changes.  After each step the program must print the header's value.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROJECT = """cmake_minimum_required(VERSION 3.25)
project(precompiled LANGUAGES CXX)
add_library(lucerna_options INTERFACE)
target_include_directories(lucerna_options INTERFACE ${PROJECT_SOURCE_DIR})
%s
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled.cpp CONTENT "")
%s
lucerna_precompile(small HEADERS <value.h>)
add_executable(program program.cpp)
target_link_libraries(program PRIVATE lucerna_options)
target_precompile_headers(program REUSE_FROM lucerna_pch_small)
"""


def part(pattern: str) -> str:
    text = (ROOT / "CMakeLists.txt").read_text()
    found = re.search(pattern, text, re.MULTILINE | re.DOTALL)
    if not found:
        sys.exit(f"CMakeLists.txt has no part that matches {pattern}")
    return found.group(0)


def run(*command: object, **options: object) -> str:
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def main() -> None:
    if shutil.which("ccache") is None:
        print("ccache is not installed: nothing to test")
        return
    launcher = part(r"^find_program\(CCACHE ccache\).*?^endif\(\)$")
    function = part(r"^function\(lucerna_precompile.*?^endfunction\(\)$")
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder)
        (source / "CMakeLists.txt").write_text(PROJECT % (launcher, function))
        environment = os.environ | {"CCACHE_DIR": str(source / "cache")}
        environment.pop("CCACHE_DISABLE", None)
        steps = (("A", True, ""), ("B", False, ""), ("A", True, ""), ("C", False, ""), ("C", False, "// a comment"))
        for number, (value, fresh, comment) in enumerate(steps):
            # Each step compiles the program; ccache cannot answer.
            (source / "program.cpp").write_text(
                f"#include <value.h>\n#include <cstdio>\nint main() {{ std::puts(kValue); return {number} * 0; }}\n")
            header = source / "value.h"
            header.write_text(f'#pragma once\ninline constexpr char kValue[] = "{value}";{comment}\n')
            if fresh:
                shutil.rmtree(source / "build", ignore_errors=True)
                run("cmake", "-G", "Ninja", "-S", source, "-B", source / "build", env=environment)
            run("cmake", "--build", source / "build", env=environment)
            printed = run(source / "build" / "program").strip()
            if printed != value:
                sys.exit(f"the header says {value}, the program says {printed}")


main()
