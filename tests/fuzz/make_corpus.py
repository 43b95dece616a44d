#!/usr/bin/python3
"""Writes the seeds of the fuzz targets into tests/fuzz/corpus.

Seeds are valid inputs, and inputs with one error.  Further inputs in these folders begin with
"found_" or "grown_"; this script leaves them alone.  --check only compares.

An input of several files joins them by lines "#FILE name" (input_files.h).
"""
import itertools
import pathlib
import sys

import seeds_formats
import seeds_gltf
import seeds_packed
import seeds_requests
import seeds_texts

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"

SEEDS = {
    "config_fuzz": seeds_texts.config,
    "eulumdat_fuzz": seeds_formats.eulumdat,
    "gltf_fuzz": lambda: itertools.chain(seeds_gltf.gltf(), seeds_packed.gltf()),
    "ies_fuzz": seeds_formats.ies,
    "pbrt_fuzz": seeds_texts.pbrt,
    "picture_fuzz": seeds_formats.picture,
    "ply_fuzz": seeds_formats.ply,
    "request_fuzz": seeds_requests.request,
    "texture_fuzz": seeds_formats.texture,
    "token_file_fuzz": seeds_texts.token_file,
}


def main():
    check = "--check" in sys.argv[1:]
    wrong = []
    for target, seeds in SEEDS.items():
        folder = CORPUS / target
        folder.mkdir(parents=True, exist_ok=True)
        made = dict(seeds())
        for path in folder.iterdir():
            if not path.name.startswith(("found_", "grown_")) and path.name not in made:
                wrong.append(f"{path}: no seed of this name")
        for name, content in made.items():
            path = folder / name
            if check:
                if not path.exists() or path.read_bytes() != content:
                    wrong.append(f"{path}: differs from the seed")
            else:
                path.write_bytes(content)
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
