#!/usr/bin/python3
"""Makes the package lucerna with its generated stubs in a folder.

    client/python/build_backend/package.py FOLDER

Writes FOLDER/lucerna and FOLDER/lucerna-VERSION.dist-info, as in site-packages.  CMake runs it for the build tree, and
backend.py for `pip install`.  Needs protoc and grpc_python_plugin (Debian's protobuf-compiler and
protobuf-compiler-grpc), and nothing else but the standard library.
"""
import email.message
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parents[1]
# In the repository, and in a source distribution, which holds a copy.
PROTO = next((p for p in (HERE.parents[1] / "proto", HERE / "proto") if (p / "lucerna/v1").is_dir()), None)
PLUGIN = "grpc_python_plugin"


def metadata():
    """The table [project] of pyproject.toml, and the text of METADATA.  The version is that of the package."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text())["project"]
    found = re.search(r'^__version__ = "([^"]+)"', (HERE / "lucerna/__init__.py").read_text(), re.M)
    if found is None:
        sys.exit("client/python/lucerna/__init__.py states no __version__")
    project["version"] = found[1]
    text = email.message.Message()
    for name, value in (("Metadata-Version", "2.1"), ("Name", project["name"]), ("Version", project["version"]),
                        ("Summary", project["description"]), ("License", project["license"]["text"]),
                        ("Requires-Python", project["requires-python"])):
        text[name] = value
    for requirement in project["dependencies"]:
        text["Requires-Dist"] = requirement
    for extra, requirements in project["optional-dependencies"].items():
        text["Provides-Extra"] = extra
        for requirement in requirements:
            text["Requires-Dist"] = f'{requirement} ; extra == "{extra}"'
    return project, text.as_string()


def make_stubs(folder):
    """Generates the messages with their types, and the stubs of gRPC, into FOLDER/lucerna/v1."""
    if PROTO is None:
        sys.exit(f"no folder proto/lucerna/v1 beside {HERE}; build in a checkout of the repository")
    for program in ("protoc", PLUGIN):
        if shutil.which(program) is None:
            sys.exit(f"no program {program}; install Debian's protobuf-compiler and protobuf-compiler-grpc")
    protos = sorted(str(f.relative_to(PROTO)) for f in (PROTO / "lucerna/v1").glob("*.proto"))
    services = [p for p in protos if re.search(r"^service ", (PROTO / p).read_text(), re.M)]
    subprocess.run(["protoc", f"-I{PROTO}", f"--python_out={folder}", f"--pyi_out={folder}", *protos], check=True)
    subprocess.run(["protoc", f"-I{PROTO}", f"--plugin=protoc-gen-grpc={shutil.which(PLUGIN)}", f"--grpc_out={folder}",
                    *services], check=True)
    (folder / "lucerna/v1/__init__.py").write_text('"""The generated messages and stubs of proto/lucerna/v1."""\n')


def make_package(folder):
    """Writes the package and its dist-info.  Returns the name of the dist-info folder."""
    folder = pathlib.Path(folder)
    project, text = metadata()
    shutil.rmtree(folder / "lucerna", ignore_errors=True)
    (folder / "lucerna").mkdir(parents=True)
    for source in sorted((HERE / "lucerna").iterdir()):
        if source.suffix == ".py" or source.name == "py.typed":
            shutil.copyfile(source, folder / "lucerna" / source.name)
    make_stubs(folder)
    info = folder / f"{project['name']}-{project['version']}.dist-info"
    info.mkdir(exist_ok=True)
    (info / "METADATA").write_text(text)
    return info.name


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    make_package(sys.argv[1])
