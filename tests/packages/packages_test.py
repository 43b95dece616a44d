#!/usr/bin/python3
"""Checks the Debian packages that `make deb` wrote.

    tests/packages/packages_test.py PACKAGE_DIR

lintian reports no error, and no warning beyond ALLOWED.  The packages have the files, the dependencies and the scripts
that they should have.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TIMEOUT_S = 1800  # ends a program that hangs
# Warnings of lintian that stay, and why.
ALLOWED = {
    "initial-upload-closes-no-bugs",  # the packages are not uploaded to Debian
    "pkg-config-unavailable-for-cross-compilation",  # the library has one folder for all architectures
}
# A file that each package must have, beside its documentation.
FILES = {
    "lucerna": ["usr/bin/lucerna", "usr/bin/lucerna-tradeoff", "usr/share/man/man1/lucerna.1.gz",
                "usr/share/man/man1/lucerna-irradiance.1.gz", "usr/share/man/man1/lucerna-tradeoff.1.gz"],
    "lucernad": ["usr/bin/lucernad", "usr/lib/lucerna/lucerna-pictures-*.so", "etc/lucernad/lucernad.toml",
                 "lib/systemd/system/lucernad.service", "usr/share/man/man8/lucernad.8.gz"],
    "liblucerna-dev": ["usr/include/lucerna/client/client.h", "usr/lib/liblucerna_client_library.a",
                       "usr/lib/cmake/lucerna/lucernaConfig.cmake", "usr/lib/pkgconfig/lucerna.pc",
                       "usr/share/lucerna/proto/lucerna/v1/lighting.proto"],
    "python3-lucerna": ["usr/lib/python3/dist-packages/lucerna/__init__.py"],
}


def output(*command):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, check=True, timeout=TIMEOUT_S).stdout


def field(package, name):
    return output("dpkg-deb", "-f", package, name).strip()


def check_lintian(packages):
    ran = subprocess.run(["lintian", "--allow-root", "--tag-display-limit", "0", *map(str, packages)],
                         capture_output=True, text=True, check=False, timeout=TIMEOUT_S)
    if ran.stderr.strip():
        yield f"lintian: {ran.stderr}"
    for line in ran.stdout.splitlines():
        found = re.match(r"([EW]): \S+: (\S+)", line)
        if found and not (found[1] == "W" and found[2] in ALLOWED):
            yield line


def check_package(package, version):
    name = field(package, "Package")
    if not field(package, "Version").startswith(f"{version}-"):
        yield f"{name}: version {field(package, 'Version')}, the project has {version}"
    if name not in FILES:
        yield f"{name}: tests/packages/packages_test.py does not list its files"
        return
    with tempfile.TemporaryDirectory() as folder:
        there = pathlib.Path(folder)
        output("dpkg-deb", "-R", package, there)
        documents = [f"usr/share/doc/{name}/copyright", f"usr/share/doc/{name}/changelog.Debian.gz"]
        for path in FILES[name] + documents:
            if not list(there.glob(path)):
                yield f"{name}: no {path}"
        sums = subprocess.run(["md5sum", "--quiet", "-c", "DEBIAN/md5sums"], cwd=there, capture_output=True, text=True,
                              check=False, timeout=TIMEOUT_S)
        if sums.returncode != 0:
            yield f"{name}: md5sums: {sums.stdout}{sums.stderr}"
        for script in ("preinst", "postinst", "prerm", "postrm"):
            if (there / "DEBIAN" / script).exists():
                output("sh", "-n", there / "DEBIAN" / script)
        for path in there.rglob("*"):
            if path.is_file() and path.read_bytes()[:4] == b"\x7fELF" and "not stripped" in output("file", path):
                yield f"{name}: {path.relative_to(there)} is not stripped"
        if name == "lucernad":
            yield from check_service(there)


def check_service(there):
    if (there / "DEBIAN/conffiles").read_text() != "/etc/lucernad/lucernad.toml\n":
        yield "lucernad: wrong conffiles"
    unit = (there / "lib/systemd/system/lucernad.service").read_text()
    if "\nExecStart=/usr/bin/lucernad --config /etc/lucernad/lucernad.toml\n" not in unit or "/local/" in unit:
        yield "lucernad: the unit does not start /usr/bin/lucernad"
    if shutil.which("systemd-analyze") is None:
        print("skipped: systemd-analyze is not installed")
        return
    # Its program and its user are not on this machine.
    changed = there / "lucernad.service"
    unit = unit.replace("=/usr/bin/lucernad ", f"={there}/usr/bin/lucernad ")
    changed.write_text(re.sub(r"(?m)^(User|Group)=lucernad$", r"\1=daemon", unit))
    verified = subprocess.run(["systemd-analyze", "verify", "--man=no", changed], capture_output=True, text=True,
                              check=False, timeout=TIMEOUT_S)
    if verified.returncode != 0 or "lucernad.service" in verified.stderr:
        yield f"lucernad: {verified.stderr}"


def check_dependencies(packages):
    """The packages depend on what images install."""
    depends = set()
    for package in packages:
        depends |= {re.match(r"[^ (|]+", entry.strip())[0] for entry in field(package, "Depends").split(",")}
    # Debian's spdlog provides this name for programs that use it with this fmt.
    depends = {re.sub(r"^(libspdlog1\.10)-fmt9$", r"\1", name) for name in depends}
    text = re.search(r"^runtime=\((.*?)^\)", (ROOT / "deploy/install-deps.sh").read_text(), re.M | re.S)[1]
    if missing := set(text.split()) - depends:
        yield f"no package depends on {sorted(missing)}, which deploy/install-deps.sh --runtime installs"


def main():
    packages = sorted(pathlib.Path(sys.argv[1]).glob("*.deb"))
    version = re.search(r"^project\(lucerna VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]
    found = list(check_dependencies(packages)) + list(check_lintian(packages))
    names = {field(package, "Package") for package in packages}
    needed = set(FILES) if (ROOT / "client/python").exists() else set(FILES) - {"python3-lucerna"}
    if missing := needed - names:
        found.append(f"no package {sorted(missing)}")
    for package in packages:
        found += check_package(package, version)
    changelog = (ROOT / "deploy/debian/changelog").read_text()
    if not changelog.startswith(f"lucerna ({version}-1) "):
        found.append(f"deploy/debian/changelog does not begin with version {version}-1")
    print("\n".join(found) or f"{len(packages)} packages are right")
    sys.exit(1 if found else 0)


main()
