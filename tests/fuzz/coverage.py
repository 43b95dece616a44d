#!/usr/bin/python3
"""Prints how many lines of each reader its corpus runs through, as a table in Markdown.

    coverage.py [--lines] [TARGET...]

Uses the programs of build/fuzz.  --lines names the lines that a corpus does not reach.  Ends with
status 1 if a corpus reaches fewer lines than it must.
"""
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build/fuzz/tests/fuzz"
LEAST_PERCENT = 80
SANITIZERS = {"ASAN_OPTIONS": "allocator_may_return_null=1:detect_leaks=0"}

# What each target reads, and the files that do it.
READERS = {
    "request_fuzz": ("requests", ["server/rpc/messages/*.cpp", "server/rpc/handlers/*.cpp"]),
    "pbrt_fuzz": (".pbrt", ["server/pbrt/*.cpp"]),
    "ply_fuzz": ("PLY", ["server/files/ply*.cpp"]),
    "ies_fuzz": ("IES", ["server/files/ies.cpp", "server/files/photometric_file.cpp"]),
    "eulumdat_fuzz": ("EULUMDAT",
                      ["server/files/eulumdat.cpp", "server/files/photometric_file.cpp"]),
    "picture_fuzz": ("pictures", ["server/pictures/*.cpp"]),
    # pbrt_fuzz reads the words of textures; texture_fuzz writes them itself.
    "texture_fuzz": ("pictures of surfaces",
                     ["server/materials/texels.cpp", "server/materials/image_lookup.cpp"]),
    "gltf_fuzz": ("glTF", ["server/gltf/*.cpp"]),
    "config_fuzz": ("configuration file",
                    ["server/lucernad/" + name for name in
                     ("configuration.cpp", "configuration_file.cpp", "setting.cpp", "setting_schema.cpp")]),
    "token_file_fuzz": ("token file", ["server/rpc/token_file.cpp"]),
}


def run(*command, **options):
    return subprocess.run([str(part) for part in command], check=True, cwd=ROOT, **options)


def lines(target, patterns):
    """(lines, lines reached) of the files."""
    program = BUILD / target
    merged = BUILD / f"{target}.profdata"
    for old in BUILD.glob(f"{target}-*.profraw"):
        old.unlink()
    run(program, "-runs=0", ROOT / "tests/fuzz/corpus" / target,
        env={**os.environ, "LLVM_PROFILE_FILE": str(BUILD / f"{target}-%m.profraw"), **SANITIZERS},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    # The program writes one file, and the library of pictures another.
    run("llvm-profdata-16", "merge", *BUILD.glob(f"{target}-*.profraw"), "-o", merged)
    library = next((ROOT / "build/fuzz/bin").glob("lucerna-pictures-*.so"))
    files = sorted({path for pattern in patterns for path in ROOT.glob(pattern)})
    out = run("llvm-cov-16", "export", program, "-object", library, f"-instr-profile={merged}", *files,
              *(["-summary-only"] if "--lines" not in sys.argv else []),
              stdout=subprocess.PIPE).stdout
    data = json.loads(out)["data"][0]
    if "--lines" in sys.argv:
        print_unreached(data)
    total = data["totals"]["lines"]
    return total["count"], total["covered"]


def print_unreached(data):
    """The beginnings of regions that no input reaches, for whoever extends a corpus."""
    for file in data["files"]:
        unreached = sorted({segment[0] for segment in file["segments"]
                            if segment[3] and segment[4] and segment[2] == 0})
        name = pathlib.Path(file["filename"]).relative_to(ROOT)
        print(f"{file['summary']['lines']['percent']:5.1f}% {name}: {unreached}", file=sys.stderr)


def main():
    chosen = [arg for arg in sys.argv[1:] if not arg.startswith("-")] or list(READERS)
    print("| reader | target | lines | reached |\n|---|---|---|---|")
    too_few = []
    for target in chosen:
        name, patterns = READERS[target]
        count, reached = lines(target, patterns)
        percent = 100 * reached / count
        print(f"| {name} | `{target}` | {count} | {percent:.1f}% |", flush=True)
        if percent < LEAST_PERCENT:
            too_few.append(target)
    for target in too_few:
        print(f"the corpus of {target} must reach {LEAST_PERCENT}% of the lines", file=sys.stderr)
    return 1 if too_few else 0


if __name__ == "__main__":
    sys.exit(main())
