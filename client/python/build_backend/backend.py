"""Builds wheels and source distributions for pip (PEP 517), with the standard library alone.

pip builds in a fresh environment, into which it would have to download setuptools.  A wheel of pure Python is a zip
file with a list of its files, so this backend writes it directly.
"""
import base64
import hashlib
import io
import pathlib
import tarfile
import tempfile
import zipfile

from package import HERE, PROTO, make_package, metadata

_WHEEL = "Wheel-Version: 1.0\nGenerator: lucerna\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
_TIME = (1980, 1, 1, 0, 0, 0)  # the same sources make the same wheel


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Writes the wheel and returns its name."""
    project, _ = metadata()
    name = f"{project['name']}-{project['version']}-py3-none-any.whl"
    with tempfile.TemporaryDirectory() as folder:
        info = pathlib.Path(folder, make_package(folder))
        (info / "WHEEL").write_text(_WHEEL)
        record = info / "RECORD"
        lines = []
        files = sorted(f for f in pathlib.Path(folder).rglob("*") if f.is_file())
        for file in files:
            content = file.read_bytes()
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            lines.append(f"{file.relative_to(folder)},sha256={digest},{len(content)}")
        record.write_text("\n".join([*lines, f"{record.relative_to(folder)},,"]) + "\n")
        with zipfile.ZipFile(pathlib.Path(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
            for file in [*files, record]:
                entry = zipfile.ZipInfo(str(file.relative_to(folder)), _TIME)
                entry.external_attr = 0o100644 << 16
                entry.compress_type = zipfile.ZIP_DEFLATED
                wheel.writestr(entry, file.read_bytes())
    return name


def build_sdist(sdist_directory, config_settings=None):
    """Writes a source distribution with the .proto files, and returns its name."""
    project, text = metadata()
    stem = f"{project['name']}-{project['version']}"
    with tarfile.open(pathlib.Path(sdist_directory, f"{stem}.tar.gz"), "w:gz") as archive:
        for folder, pattern in (("lucerna", "*.py"), ("lucerna", "py.typed"), ("build_backend", "*.py")):
            for file in sorted((HERE / folder).glob(pattern)):
                archive.add(file, f"{stem}/{folder}/{file.name}")
        archive.add(HERE / "pyproject.toml", f"{stem}/pyproject.toml")
        for file in sorted((PROTO / "lucerna/v1").glob("*.proto")):
            archive.add(file, f"{stem}/proto/lucerna/v1/{file.name}")
        info = tarfile.TarInfo(f"{stem}/PKG-INFO")
        info.size = len(text.encode())
        archive.addfile(info, io.BytesIO(text.encode()))
    return f"{stem}.tar.gz"
