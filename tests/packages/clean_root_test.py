#!/usr/bin/python3
"""Installs the Debian packages in a new Debian, asks a question there, and purges them.

    tests/packages/clean_root_test.py PACKAGE_DIR [ROOT]

Needs root and a mirror of Debian 12.  mmdebstrap makes the new Debian, unless ROOT is one that it made before; ROOT is
copied and stays as it is.  The commands run in a chroot with processes and mounts of its own, so everything that they
start ends with them.
"""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SCENES = HERE.parents[1] / "scenes"
MIRROR = os.environ.get("LUCERNA_DEBIAN_MIRROR", "http://deb.debian.org/debian")
TIMEOUT_S = 3600  # ends a test that hangs
# What the package manager itself remembers of packages that are gone.
REMEMBERED = ("var/log/", "var/cache/", "var/lib/apt/", "var/lib/dpkg/", "root/packages/", "run/", "proc/", "tmp/")


def run(*command, **keywords):
    ran = subprocess.run([*map(str, command)], check=False, timeout=TIMEOUT_S, **keywords)
    if ran.returncode != 0:
        sys.exit(f"exit status {ran.returncode}: {' '.join(map(str, command))}")
    return ran


def make_root(root, base):
    if base:
        run("cp", "-a", f"{base}/.", root)
    else:
        run("mmdebstrap", "--variant=minbase", "--hook-dir=/usr/share/mmdebstrap/hooks/merged-usr",
            "--dpkgopt=force-unsafe-io", "--format=directory", "bookworm", root, MIRROR)
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
    # No service starts in a chroot.
    policy = root / "usr/sbin/policy-rc.d"
    policy.write_text("#!/bin/sh\nexit 101\n")
    policy.chmod(0o755)


def inside(root, script):
    """Runs tests/packages/SCRIPT in the root."""
    shutil.copy(HERE / script, root / "root" / script)
    run("unshare", "--mount", "--pid", "--fork", "--kill-child", f"--mount-proc={root}/proc", "chroot", root,
        "/usr/bin/env", "-i", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL=C.UTF-8", "DEBIAN_FRONTEND=noninteractive",
        "sh", "-eu", f"/root/{script}")


def traces(root):
    """Paths and users with the name of the packages."""
    found = []
    for folder, folders, files in os.walk(root):
        for name in [*folders, *files]:
            path = os.path.relpath(os.path.join(folder, name), root)
            if "lucern" in name and not path.startswith(REMEMBERED):
                found.append(path)
    for table in ("passwd", "group", "shadow"):
        if "lucern" in (root / "etc" / table).read_text():
            found.append(f"a line in etc/{table}")
    return sorted(found)


def main():
    # An exception ends the running command and removes the root.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("got SIGTERM"))
    packages = sorted(pathlib.Path(sys.argv[1]).glob("*.deb"))
    if not packages:
        sys.exit(f"{sys.argv[1]}: no packages")
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder, "root")
        root.mkdir(mode=0o755)
        make_root(root, sys.argv[2] if len(sys.argv) > 2 else None)
        (root / "root/packages").mkdir()
        for package in packages:
            shutil.copy(package, root / "root/packages")
        for scene in ("demo.pbrt", "wallwasher.ies", "batwing.ies"):
            shutil.copy(SCENES / scene, root / "root/packages")
        if traces(root):
            sys.exit(f"before the installation: {traces(root)}")
        inside(root, "install_and_ask.sh")
        if not traces(root):
            sys.exit("no trace of the packages after the installation")
        inside(root, "purge.sh")
        if left := traces(root):
            sys.exit(f"left behind: {left}")
    print("installed, answered, purged")


main()
