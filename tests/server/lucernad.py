"""A lucernad for a test in Python, on a free port of the loopback interface."""
import os
import pathlib
import select
import subprocess
import sys
import tempfile
import time

START_S = END_S = 600  # end tests that hang


def expect(condition, text):
    """Ends the test with an error if the condition is false."""
    if not condition:
        sys.exit(f"{pathlib.Path(sys.argv[0]).stem}: {text}")


class Lucernad:
    """Runs `lucernad`.  Leaving the `with` block stops it."""

    def __init__(self, program, *options, **popen):
        self.directory = tempfile.TemporaryDirectory()
        self.log_file = open(pathlib.Path(self.directory.name, "log"), "w+")
        environment = {k: v for k, v in os.environ.items() if not k.startswith("LUCERNA")}
        environment.update(popen.pop("environment", {}))
        listen = [] if "--listen" in options else ["--listen", "127.0.0.1:0"]
        root = [] if "--scene-root" in options else ["--scene-root", self.directory.name]
        self.process = subprocess.Popen(
            [program, *listen, *root, "--threads", "2", *map(str, options)], stdout=subprocess.PIPE,
            stderr=self.log_file, stdin=subprocess.DEVNULL, env=environment, **popen)

    def __enter__(self):
        text, end = b"", time.monotonic() + START_S
        while b"\n" not in text:
            ready, _, _ = select.select([self.process.stdout], [], [], max(0, end - time.monotonic()))
            more = os.read(self.process.stdout.fileno(), 4096) if ready else b""
            if not more:
                log = self.log()
                self.__exit__()
                sys.exit(f"{pathlib.Path(sys.argv[0]).stem}: lucernad does not start: {log}")
            text += more
        self.address = text.decode().removeprefix("listening on ").strip()
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.terminate()
        try:
            self.process.wait(END_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()
        self.log_file.close()
        self.directory.cleanup()

    @property
    def port(self):
        return int(self.address.rpartition(":")[2])

    def log(self):
        """The server's standard error so far."""
        return pathlib.Path(self.log_file.name).read_text()

    def wait_for_log(self, text, seconds=END_S, count=1):
        """Returns when the log has the text `count` times."""
        end = time.monotonic() + seconds
        while self.log().count(text) < count:
            expect(time.monotonic() < end, f"{text!r} is not in the log:\n{self.log()}")
            time.sleep(0.01)
