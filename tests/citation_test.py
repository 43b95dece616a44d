#!/usr/bin/python3
"""CITATION.cff is valid, and states the project's version and licence.

    tests/citation_test.py [FILE]

The rules are those of the schema of the Citation File Format 1.2.0 for the keys that the file has.
"""
import pathlib
import re
import sys

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[1]
REQUIRED = {"authors", "cff-version", "message", "title"}
# Keys of the schema that the file may have, with the type of their value.
KNOWN = {"authors": list, "cff-version": str, "message": str, "title": str, "type": str, "abstract": str, "version": str,
         "license": str, "keywords": list}
ENTITY = {"name"}  # keys of an author that is not a person


def faults(text):
    try:
        content = yaml.load(text, yaml.BaseLoader)
    except yaml.YAMLError as error:
        yield str(error)
        return
    for key in sorted(REQUIRED - content.keys()):
        yield f"{key} is missing"
    for key, value in content.items():
        if key not in KNOWN:
            yield f"{key}: no key that this test knows"
        elif not isinstance(value, KNOWN[key]) or not value:
            yield f"{key} = {value!r}, expected a {KNOWN[key].__name__} that is not empty"
    if content.get("cff-version") != "1.2.0":
        yield f"cff-version = {content.get('cff-version')}, expected 1.2.0"
    if content.get("type") not in ("software", "dataset"):
        yield f"type = {content.get('type')}, expected software"
    for author in content.get("authors", []):
        if not isinstance(author, dict) or author.keys() != ENTITY or not author["name"]:
            yield f"authors: {author}, expected an entity with a name"
    version = re.search(r"^project\(lucerna VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
    if content.get("version") != version:
        yield f"version = {content.get('version')}, the project has {version}"
    if content.get("license") != "Apache-2.0" or "Apache License" not in (ROOT / "LICENSE").read_text():
        yield f"license = {content.get('license')} is not that of the file LICENSE"
    if len(content.get("keywords", [])) != len(set(content.get("keywords", []))):
        yield "keywords: one is there twice"


def main():
    text = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "CITATION.cff").read_text()
    found = list(faults(text))
    # Each rule sees a file that breaks it.
    for old, new in (("title:", "titel:"), ("1.2.0", "1.1.0"), ("software\n", "program\n"), ("- name: The", "- The"),
                     ("license: Apache-2.0", "license: MIT"), ("version: 0", "version: 9"), ("- rendering", "- lighting"),
                     ("title: Lucerna", "title: [")):
        if old not in text or not list(faults(text.replace(old, new))):
            found.append(f"no fault is found after {old!r} became {new!r}")
    print("\n".join(found))
    sys.exit(1 if found else 0)


main()
