#!/usr/bin/python3
"""Checks that includes between rooms run one way.

    tests/rooms_test.py [ROOT]

A room is a folder of product code.  A file may include files of its own room and of rooms that come before it in
ROOMS, if ALLOWED permits their top-level folders.  Names both files of each include that breaks this.  Also fails if a
room has more than 30 units (a header and its source are one unit), or if a folder is not in ROOMS.
"""
import pathlib
import re
import sys
import tempfile

ROOMS = [
    "proto", "proto/common",
    "lights/maths", "lights/sampling", "lights/pictures", "lights/shapes", "lights/models",
    "server/runtime", "server/files", "server/pictures", "server/materials", "server/description", "server/pbrt",
    "server/gltf", "server/rays", "server/scene", "server/store", "server/visibility", "server/estimate",
    "server/queries", "server/monitor", "server/rpc/messages", "server/rpc/handlers", "server/rpc", "server/lucernad",
    "client/library", "client/files", "client/testing", "client/terminal", "client/tradeoff", "client/lab", "client/cli",
]
ALLOWED = {"proto": {"proto"}, "lights": {"lights"}, "server": {"server", "lights", "proto"},
           "client": {"client", "proto"}}
# Libraries that lights must not include.
FORBIDDEN_IN_LIGHTS = ("grpc", "google/", "embree", "lucerna/v1")
MOST_UNITS = 30


def faults(root):
    files = sorted(f for top in ALLOWED for f in (root / top).rglob("*") if f.suffix in (".h", ".cpp"))
    names = {str(f.relative_to(root)) for f in files}
    # Public headers of the client have a second name after installation.
    public = {f"lucerna/client/{pathlib.Path(n).name}": n for n in names if n.startswith("client/") and n.endswith(".h")}
    for name in ("local_server.h", "local_server_test.h"):
        public[f"lucerna/client/testing/{name}"] = f"client/testing/{name}"
    units = {}
    for file in files:
        name = str(file.relative_to(root))
        room = str(pathlib.PurePath(name).parent)
        if room not in ROOMS:
            yield f"{name}: {room} is not in ROOMS"
            continue
        units.setdefault(room, set()).add(file.stem)
        for included in re.findall(r'^#include ["<]([^">]+)[">]', file.read_text(), re.M):
            if name.startswith("lights/") and included.startswith(FORBIDDEN_IN_LIGHTS):
                yield f"{name} includes {included}, which lights must not include"
            included = public.get(included, included)
            if included not in names:
                continue
            other = str(pathlib.PurePath(included).parent)
            if included.split("/")[0] not in ALLOWED[name.split("/")[0]]:
                yield f"{name} includes {included}: {name.split('/')[0]} does not depend on {included.split('/')[0]}"
            elif other in ROOMS and ROOMS.index(other) > ROOMS.index(room):
                yield f"{name} includes {included}: {room} comes before {other}"
    for room, held in units.items():
        if len(held) > MOST_UNITS:
            yield f"{room} holds {len(held)} units, allowed {MOST_UNITS}"


def check_that_faults_are_found():
    """Checks that each kind of fault is found, in a tree with one of each."""
    wrong = {
        "lights/maths/vec.h": '#include "lights/models/light.h"\n',
        "lights/models/light.h": "#include <grpcpp/grpcpp.h>\n",
        "client/library/client.h": '#include "server/rays/ray.h"\n',
        "server/rays/ray.h": "",
        "server/attic/old.h": "",
    }
    wrong |= {f"server/pbrt/file{i}.cpp": "" for i in range(MOST_UNITS + 1)}
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in wrong.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text)
        seen = list(faults(root))
    if len(seen) != 5:
        sys.exit("not every fault of the example is found:\n" + "\n".join(seen))


def main():
    check_that_faults_are_found()
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[1]
    found = list(faults(root))
    print("\n".join(found))
    sys.exit(1 if found else 0)


main()
