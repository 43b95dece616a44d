"""The blocks of docs/python.md run from top to bottom."""
import re
import shutil

import lucerna
import pytest
from conftest import ROOT, WAIT_S

PAGE = (ROOT / "docs/python.md").read_text()
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)


def test_the_blocks_run_and_print_what_they_state(tmp_path, monkeypatch, capsys):
    pytest.importorskip("matplotlib")
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")
    (tmp_path / "build").mkdir()
    monkeypatch.chdir(tmp_path)
    assert len(BLOCKS) >= 9
    with lucerna.local("scenes", patience=WAIT_S) as server:
        monkeypatch.setenv("LUCERNA_SERVER", server.target)
        names = {}
        for block in BLOCKS:
            capsys.readouterr()
            exec(compile(block, "docs/python.md", "exec"), names)
            printed = capsys.readouterr().out
            for stated in re.findall(r"^ *print\(.*\)  # (.*)$", block, re.M):
                if stated != "in lumens":
                    assert stated in printed.splitlines()
    assert (tmp_path / "build/map.png").is_file()


@pytest.mark.parametrize("page, example", [("docs/python.md", "map.py"), ("README.md", "power.py")])
def test_pages_show_the_examples_verbatim(page, example):
    text = (ROOT / "docs/examples/python" / example).read_text()
    assert f"```python\n{text}```\n" in (ROOT / page).read_text()


def test_every_method_and_variable_is_on_the_page():
    for kind, name in ((lucerna.Scene, "scene"), (lucerna.Server, "server")):
        for method in vars(kind):
            if not method.startswith("_") and method not in ("close", "target", "scene", "id") and callable(
                    getattr(kind, method)):
                assert f"{name}.{method}" in PAGE or f"{method}(" in PAGE, method
    assert set(re.findall(r"LUCERNA_[A-Z_]+", (ROOT / "client/python/lucerna/_channel.py").read_text())) <= set(
        re.findall(r"LUCERNA_[A-Z_]+", PAGE))
    for error in lucerna.Error.__subclasses__():
        assert f"`{error.__name__}`" in PAGE
