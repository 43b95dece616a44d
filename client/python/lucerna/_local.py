"""A private lucernad for tests and notebooks."""
from __future__ import annotations

import os
import pathlib
import select
import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from types import TracebackType
from typing import Self

import grpc

from lucerna._channel import settings
from lucerna._client import Path, Server
from lucerna._errors import DeadlineExceeded, NotFound, Unavailable
from lucerna._steps import Transport

_LISTENING = "listening on "


def find_program(program: Path | None = None) -> str:
    """The program lucernad: the argument, the variable LUCERNAD, or the one on PATH.  NotFound if there is none."""
    wanted = os.fspath(program) if program is not None else os.environ.get("LUCERNAD") or "lucernad"
    found = shutil.which(wanted)
    if found is None:
        raise NotFound(f"no program {wanted}; set LUCERNAD, or put lucernad on PATH")
    return found


class LocalServer(Server):
    """A running lucernad, a child of this process, and the connection to it.  `lucerna.local` starts one."""

    def __init__(self, program: Path | None, scene_root: Path, threads: int, load: Sequence[Path],
                 arguments: Sequence[str], patience_s: float, timeout_s: float | None) -> None:
        command = [find_program(program), "--listen", "127.0.0.1:0", "--scene-root", os.fspath(scene_root)]
        command += ["--threads", str(threads)] if threads else []
        for path in load:
            command += ["--load", os.fspath(path)]
        # The server ends with this process, also if this process is killed.  setpriv becomes the server, so it has one
        # process id.
        if shutil.which("setpriv") is not None:
            command = ["setpriv", "--pdeathsig", "KILL", "--", *command]
        # Variables of the caller's own server must not change this one.
        environment = {k: v for k, v in os.environ.items() if not k.startswith("LUCERNAD_")}
        self._patience_s = patience_s
        self._log = tempfile.TemporaryFile()
        self._process = subprocess.Popen([*command, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                         stderr=self._log, env=environment)
        try:
            end = time.monotonic() + patience_s
            # Not the caller's environment: this server has neither TLS nor tokens unless `arguments` say so.
            transport = Transport(settings(self._address(end), environment={}), 4)
            super().__init__(transport, timeout_s)
            self._wait_until_serving(end)
        except BaseException:
            self.stop()
            raise

    def _address(self, end: float) -> str:
        assert self._process.stdout is not None
        text = b""
        while True:
            for line in text.decode(errors="replace").split("\n")[:-1]:
                if line.startswith(_LISTENING):
                    return line.removeprefix(_LISTENING).strip()
            ready, _, _ = select.select([self._process.stdout], [], [], max(0.0, end - time.monotonic()))
            if not ready:
                raise DeadlineExceeded(self._failure(f"it prints no address within {self._patience_s:g} s"))
            more = os.read(self._process.stdout.fileno(), 4096)
            if not more:
                status = self._process.wait()
                raise Unavailable(self._failure(f"it ended with exit status {status}"))
            text += more

    def _wait_until_serving(self, end: float) -> None:
        health = self._transport._channel.unary_unary("/grpc.health.v1.Health/Check")
        while True:
            try:
                if health(b"", timeout=max(0.1, end - time.monotonic())) == b"\x08\x01":  # SERVING
                    return
            except grpc.RpcError as error:
                if time.monotonic() > end or self._process.poll() is not None:
                    raise Unavailable(self._failure(f"it does not serve: {error}")) from None
            time.sleep(0.01)

    def _failure(self, what: str) -> str:
        return f"lucernad did not start: {what}; its stderr: {self.log() or '(empty)'}"

    @property
    def process_id(self) -> int:
        """The process id of lucernad."""
        return self._process.pid

    def log(self) -> str:
        """The server's standard error so far."""
        if self._log.closed:
            return ""
        size = os.fstat(self._log.fileno()).st_size
        return os.pread(self._log.fileno(), size, 0).decode(errors="replace")  # the server writes at the offset

    def stop(self) -> int:
        """Sends SIGTERM to the server and waits; kills it if it does not end within the patience.

        Returns the exit status, negative for a signal.  Later calls return the same.
        """
        if self._process.poll() is None:
            self._process.terminate()
        try:
            return self._process.wait(self._patience_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()
        finally:
            if self._process.stdout is not None:
                self._process.stdout.close()

    def close(self) -> None:
        """Closes the connection and stops the server."""
        super().close()
        self.stop()
        self._log.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()


def local(scene_root: Path = ".", *, load: Sequence[Path] = (), threads: int = 0, arguments: Sequence[str] = (),
          program: Path | None = None, patience: float = 60.0, timeout: float | None = None) -> LocalServer:
    """Starts a lucernad on a free port of the loopback interface; leaving the `with` block stops it.

        with lucerna.local("scenes") as server:
            scene = server.load("room/scene.pbrt")

    scene_root: folder of the scene files.  load: scenes to load before it serves, relative to scene_root.  threads:
    compute threads; 0 is one for each processor.  arguments: further options of lucernad.  program: the program; by
    default the variable LUCERNAD, then PATH.  patience: limit for its start and its end [s].  timeout: for each method
    [s], default none.  Errors: NotFound without a program, Unavailable or DeadlineExceeded with the server's log if it
    does not start.
    """
    return LocalServer(program, pathlib.Path(scene_root), threads, load, arguments, patience, timeout)
