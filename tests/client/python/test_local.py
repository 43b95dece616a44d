"""A private server starts, serves and stops."""
import os
import pathlib
import signal
import subprocess
import sys
import time

import lucerna
import pytest
from conftest import REFERENCE, WAIT_S


def gone(process_id):
    """Waits until there is no such process."""
    end = time.monotonic() + WAIT_S
    while pathlib.Path(f"/proc/{process_id}").exists():
        assert time.monotonic() < end, "the server still runs"
        time.sleep(0.02)


def test_the_block_starts_and_stops_it():
    with lucerna.local(REFERENCE, load=["point.pbrt"], threads=1, patience=WAIT_S) as server:
        assert server.target.startswith("127.0.0.1:") and server.info().threads == 1
        assert [s.path for s in server.scenes()] == ["point.pbrt"] and "listens on" in server.log()
        process_id = server.process_id
        assert pathlib.Path(f"/proc/{process_id}/comm").read_text().strip() == "lucernad"
    gone(process_id)
    assert server.stop() == 0
    with pytest.raises(Exception):
        server.info()


def test_it_stops_when_the_block_fails():
    with pytest.raises(KeyError):
        with lucerna.local(REFERENCE, patience=WAIT_S) as server:
            raise KeyError("wrong")
    gone(server.process_id)


def test_a_server_that_ignores_sigterm_is_killed(tmp_path):
    """A stopped process does not react to SIGTERM."""
    with lucerna.local(REFERENCE, patience=WAIT_S) as server:
        os.kill(server.process_id, signal.SIGSTOP)
        server._patience_s = 0.2
        assert server.stop() == -signal.SIGKILL


def test_it_ends_with_the_program_that_started_it():
    program = subprocess.Popen(
        [sys.executable, "-c", f"import lucerna, time\nserver = lucerna.local({str(REFERENCE)!r}, patience={WAIT_S})\n"
         f"print(server.process_id, flush=True)\ntime.sleep({WAIT_S})"], stdout=subprocess.PIPE, text=True)
    process_id = int(program.stdout.readline())
    program.kill()
    program.wait()
    program.stdout.close()
    gone(process_id)


def test_a_failed_start_has_the_log_of_the_server(tmp_path):
    with pytest.raises(lucerna.Unavailable, match="(?s)exit status 1.*missing"):
        lucerna.local(tmp_path / "missing", patience=WAIT_S)
    with pytest.raises(lucerna.Unavailable, match="(?s)exit status 2.*no-such-option"):
        lucerna.local(tmp_path, arguments=["--no-such-option"], patience=WAIT_S)


def test_the_program_is_found(monkeypatch, tmp_path):
    program = os.environ["LUCERNAD"]
    monkeypatch.delenv("LUCERNAD")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(lucerna.NotFound, match="set LUCERNAD, or put lucernad on PATH"):
        lucerna.local(REFERENCE)
    with lucerna.local(REFERENCE, program=program, patience=WAIT_S) as server:
        assert server.info().version == lucerna.__version__
    monkeypatch.setenv("PATH", str(pathlib.Path(program).parent))
    with lucerna.local(REFERENCE, patience=WAIT_S) as server:
        assert server.info().version == lucerna.__version__


def test_variables_of_another_server_have_no_effect(monkeypatch):
    monkeypatch.setenv("LUCERNAD_LISTEN", "256.0.0.1:1")
    monkeypatch.setenv("LUCERNAD_THREADS", "nonsense")
    monkeypatch.setenv("LUCERNA_TLS", "1")
    with lucerna.local(REFERENCE, patience=WAIT_S) as server:
        assert server.info().threads >= 1


def test_the_fixture_of_the_plugin(tmp_path):
    (tmp_path / "conftest.py").write_text('pytest_plugins = ["lucerna.pytest_plugin"]\n')
    (tmp_path / "pytest.ini").write_text(f"[pytest]\nlucerna_scene_root = {REFERENCE}\n")
    (tmp_path / "test_it.py").write_text(
        "def test_it(lucerna_server):\n    assert lucerna_server.load('point.pbrt').power().total > 0\n"
        "    open('process', 'w').write(str(lucerna_server.process_id))\n")
    outcome = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"], cwd=tmp_path, text=True,
                             capture_output=True, timeout=WAIT_S, check=False)
    assert outcome.returncode == 0 and "1 passed" in outcome.stdout, outcome.stdout
    gone(int((tmp_path / "process").read_text()))
