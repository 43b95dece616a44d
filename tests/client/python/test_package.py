"""The package installs without network, its types are right, and its answers become tables and plots."""
import ast
import importlib.metadata
import inspect
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

import lucerna
import numpy as np
import pytest
from conftest import ROOT, WAIT_S

UP = (0.0, 0.0, 1.0)
SOURCE = ROOT / "client/python"
PACKAGE = pathlib.Path(lucerna.__file__).parent


def run(*command, **options):
    outcome = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=WAIT_S, check=False,
                             **options)
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    return outcome.stdout


def sources():
    return sorted(f for f in SOURCE.rglob("*") if "__pycache__" not in f.parts)


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """A virtual environment with Debian's packages and the installed package; pip had no network."""
    folder = tmp_path_factory.mktemp("venv")
    pytest.importorskip("pip")
    made = subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", folder],
                          capture_output=True, text=True, timeout=WAIT_S, check=False)
    if made.returncode != 0:
        pytest.skip(f"venv does not work here: {made.stderr or made.stdout}")
    # As root the network is away; otherwise pip has an index that does not exist.
    alone = os.geteuid() == 0 and subprocess.run(["unshare", "-n", "true"], check=False).returncode == 0
    offline = ["unshare", "-n"] if alone else []
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")} | {
        "PIP_INDEX_URL": "http://127.0.0.1:9/", "PIP_NO_CACHE_DIR": "1"}
    before = sources()
    run(*offline, folder / "bin/python", "-m", "pip", "install", SOURCE, env=clean)
    assert sources() == before, "pip left files in the sources"
    return folder, clean


def test_pip_installs_it_without_network(environment, server):
    folder, clean = environment
    code = ("import lucerna, sys; print(lucerna.__file__); "
            "print(lucerna.connect(sys.argv[1]).load('point.pbrt').power().total)")
    text = run(folder / "bin/python", "-c", code, server.target, env=clean, cwd="/")
    place, power = text.split()
    assert place.startswith(str(folder)) and float(power) == pytest.approx(40 * np.pi)
    assert "lucerna" in run(folder / "bin/python", "-m", "pip", "list", env=clean)
    run(folder / "bin/python", "-m", "pip", "uninstall", "-y", "lucerna", env=clean)
    assert not list(folder.rglob("lucerna*"))


def test_a_source_distribution_builds_the_same_wheel(tmp_path):
    build = "import sys; sys.path.insert(0, 'build_backend'); import backend; backend.build_{}({!r})"
    run(sys.executable, "-B", "-c", build.format("wheel", str(tmp_path)), cwd=SOURCE)
    run(sys.executable, "-B", "-c", build.format("sdist", str(tmp_path)), cwd=SOURCE)
    archive, = tmp_path.glob("*.tar.gz")
    shutil.unpack_archive(archive, tmp_path / "unpacked")
    again = tmp_path / "again"
    again.mkdir()
    inner, = (tmp_path / "unpacked").iterdir()
    run(sys.executable, "-B", "-c", build.format("wheel", str(again)), cwd=inner)
    wheel, = tmp_path.glob("*.whl")
    assert (again / wheel.name).read_bytes() == wheel.read_bytes()
    names = zipfile.ZipFile(wheel).namelist()
    assert {"lucerna/__init__.py", "lucerna/py.typed", "lucerna/v1/lighting_pb2.pyi"} <= set(names)


def test_version_is_that_of_the_programs(server):
    assert lucerna.__version__ == server.info().version
    assert f"VERSION {lucerna.__version__} " in (ROOT / "CMakeLists.txt").read_text()
    found, = importlib.metadata.distributions(name="lucerna", path=[str(PACKAGE.parent)])
    assert found.version == lucerna.__version__


def test_the_build_tree_lists_every_module():
    listed = re.search(r"set\(MODULES(.*?)\)", (SOURCE / "CMakeLists.txt").read_text(), re.S)[1].split()
    assert sorted(listed) == sorted(f.stem for f in (SOURCE / "lucerna").glob("*.py"))


def test_the_installation_has_the_package(tmp_path, server):
    """Debian's interpreter finds lib/python3/dist-packages of its prefix."""
    build = PACKAGE.parents[1]
    run("cmake", "--install", build, "--component", "python", "--prefix", tmp_path)
    place = tmp_path / "lib/python3/dist-packages"
    assert sorted(f.name for f in place.iterdir()) == ["lucerna", f"lucerna-{lucerna.__version__}.dist-info"]
    assert not list(place.rglob("*.pyc"))
    code = "import lucerna, sys; print(lucerna.__file__); lucerna.connect(sys.argv[1]).info()"
    text = run(sys.executable, "-B", "-c", code, server.target, env=os.environ | {"PYTHONPATH": str(place)})
    assert text.startswith(str(place))


@pytest.fixture(scope="module")
def mypy_cache(tmp_path_factory):
    return tmp_path_factory.mktemp("mypy")


def mypy(tmp_path, cache, *arguments):
    pytest.importorskip("mypy")
    return subprocess.run([sys.executable, "-m", "mypy", "--config-file", SOURCE / "pyproject.toml", "--strict",
                           "--cache-dir", cache, *arguments], capture_output=True, text=True,
                          timeout=WAIT_S, check=False, cwd=tmp_path, env=os.environ | {"MYPYPATH": str(PACKAGE.parent)})


def test_mypy_finds_no_error(tmp_path, mypy_cache):
    outcome = mypy(tmp_path, mypy_cache, "-p", "lucerna")
    assert outcome.returncode == 0, outcome.stdout


def test_mypy_knows_the_types_of_answers(tmp_path, mypy_cache):
    """Decorators and generators keep the types of arguments and answers."""
    (tmp_path / "user.py").write_text(
        "import lucerna\n\n"
        "scene = lucerna.connect().load('a.pbrt')\n"
        "scene.irradiance([0, 0, 0], [0, 0, 1], samples='many')\n"
        "scene.irradiance([0, 0, 0], [0, 0, 1]).radiance\n\n\n"
        "async def ask() -> lucerna.Power:\n"
        "    other = await lucerna.aio.connect().load('a.pbrt')\n"
        "    return await other.le([0, 0, 0], [0, 0, 1])\n")
    outcome = mypy(tmp_path, mypy_cache, "user.py")
    found = dict(re.findall(r"^user.py:(\d+): error: (.*)$", outcome.stdout, re.M))
    assert sorted(found, key=int) == ["4", "5", "10"], outcome.stdout + outcome.stderr
    assert 'incompatible type "str"; expected "Optional[int]"' in found["4"]
    assert '"Irradiance" has no attribute "radiance"' in found["5"]
    assert '(got "Radiance", expected "Power")' in found["10"]


def test_help_shows_arguments_and_answers():
    for kind in (lucerna.Scene, lucerna.aio.Scene):
        signature = inspect.signature(kind.pdf_li)
        assert signature.return_annotation == "results.LightDensity"
        assert list(signature.parameters)[:4] == ["scene", "points", "wi", "light"]


def test_every_call_of_the_contract_is_made():
    """A new call must get its method.  Reflection and health are standard services of gRPC."""
    calls = set()
    for file in (ROOT / "proto/lucerna/v1").glob("*.proto"):
        text = file.read_text()
        for service, body in re.findall(r"^service (\w+) \{(.*?)^\}", text, re.M | re.S):
            calls |= {f"{service}/{call}" for call in re.findall(r"^  rpc (\w+)\(", body, re.M)}
    words = {node.value for file in (SOURCE / "lucerna").glob("*.py") for node in ast.walk(ast.parse(file.read_text()))
             if isinstance(node, ast.Constant)}
    assert len(calls) > 20 and calls - words == set()
    page = (ROOT / "docs/python.md").read_text()
    assert {c.partition("/")[2] for c in calls if c.partition("/")[2] not in page} == set()


def test_public_things_have_docstrings():
    for name in lucerna.__all__:
        thing = getattr(lucerna, name)
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if not member.startswith("_") and callable(value):
                    assert inspect.getdoc(value), f"{name}.{member}"
        assert name == "STATUS" or inspect.getdoc(thing), name


def test_fields_of_answers_state_units_or_shapes():
    tree = ast.parse((SOURCE / "lucerna/_results.py").read_text())
    lines = (SOURCE / "lucerna/_results.py").read_text().splitlines()
    known = ("[", "shape", "as `low`")
    for node in tree.body:
        for field in node.body if isinstance(node, ast.ClassDef) else ():
            if isinstance(field, ast.AnnAssign) and field.target.id not in ("cost", "shares", "estimates", "high",
                                                                            "spectral_standard_error"):
                text = lines[field.end_lineno - 1]
                assert "#:" in text and any(word in text for word in known), f"{node.name}.{field.target.id}"


def test_answers_become_tables(rectangle, points):
    pandas = pytest.importorskip("pandas")
    light = rectangle.irradiance(points, UP, samples=16, bounces=0)
    table = light.frame()
    assert isinstance(table, pandas.DataFrame) and len(table) == 40
    assert list(table.columns[:9]) == ["x", "y", "z", "nx", "ny", "nz", "illuminance_lx", "low_lx", "high_lx"]
    assert np.array_equal(table["illuminance_lx"], light.illuminance) and np.array_equal(table["y"], points[:, 1])
    samples = rectangle.sample_li(points, samples=3, test_visibility=True)
    assert len(samples.frame()) == 120 and np.array_equal(samples.frame()["wi_z"], samples.wi[..., 2].ravel())
    rays = rectangle.sample_le(7, light=1)
    for answer, rows in ((rays, 7), (rectangle.pdf_le(rays, light=1), 7), (rectangle.le(points, UP), 40),
                         (rectangle.pdf_li(points, UP, light=1), 40), (rectangle.visible(points, points), 40),
                         (rectangle.power(), 1), (rectangle.lights(), 1)):
        assert len(answer.frame()) == rows, answer
    assert rectangle.lights().frame()["kind"][0] == "diffuse_area"


def test_without_pandas_a_table_is_refused(rectangle, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError):
        rectangle.power().frame()


def test_answers_become_plots(rectangle, points, tmp_path):
    """The colours of the map are those of its numbers."""
    pytest.importorskip("matplotlib")
    import matplotlib.image
    floor = lucerna.grid((-2, -2, 0.01), (4, 0, 0), (0, 2, 0), columns=16, rows=8)
    light = rectangle.irradiance(floor, samples=16, bounces=0, accuracy=lucerna.Accuracy(closed_forms="off"))
    figure = light.plot(tmp_path / "map.png")
    maps, half = figure.axes[:2]
    known = light.status == 1  # some points lie in the box and in the ball
    assert 0 < known.mean() < 1
    for panel, wanted in ((maps, light.illuminance), (half, (light.high - light.low) / 2)):
        drawn = panel.collections[0].get_array().reshape(8, 16)
        assert np.array_equal(drawn.data[known], wanted[known]) and np.array_equal(drawn.mask, ~known)
    assert (maps.get_xlabel(), maps.get_ylabel()) == ("x [m]", "y [m]")
    picture = matplotlib.image.imread(tmp_path / "map.png")
    assert picture.shape[1] > picture.shape[0] > 100 and picture[..., :3].std() > 0.05
    assert len(light.plot(intervals=False).axes) == 2  # the map and its scale
    line = rectangle.irradiance(np.linspace((-2, -2, 0.01), (2, -2, 0.01), 30), UP, samples=16, bounces=0).plot()
    assert line.axes[0].get_xlim()[1] > 3.9
    rectangle.sample_li(points, samples=8).plot(tmp_path / "directions.png")
    rectangle.sample_le(100).plot(tmp_path / "rays.png")
    rectangle.power().plot(tmp_path / "power.png")
    rectangle.render(samples=1).plot(tmp_path / "picture.png")
    assert len(list(tmp_path.glob("*.png"))) == 5


def test_plots_do_not_load_pyplot(rectangle):
    """pyplot keeps every figure and may need a display."""
    pytest.importorskip("matplotlib")
    code = ("import lucerna, sys; assert 'matplotlib' not in sys.modules and 'pandas' not in sys.modules; "
            "lucerna.connect(sys.argv[1]).scene(sys.argv[2]).power().plot(); "
            "assert 'matplotlib.pyplot' not in sys.modules")
    run(sys.executable, "-c", code, rectangle._transport.connection.target, rectangle.id)
