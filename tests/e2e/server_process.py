"""A lucernad of its own for a test in Python, and the answers of the command line in JSON."""
import json
import os
import select
import signal
import subprocess
import time

START_S = 600  # ends tests that hang
COMMAND_S = 900


class ServerProcess:
    """Runs `lucernad` on a free port of the loopback interface.  Leaving the `with` block stops it."""

    def __init__(self, build, scene_root, *arguments, log=subprocess.DEVNULL):
        self.build = build
        environment = {k: v for k, v in os.environ.items() if not k.startswith("LUCERNA")}
        self.process = subprocess.Popen(
            [build / "bin/lucernad", "--listen", "127.0.0.1:0", "--scene-root", scene_root, "--threads", "2",
             *arguments],
            stdout=subprocess.PIPE, stderr=log, stdin=subprocess.DEVNULL, env=environment,
        )
        self.environment = environment

    def __enter__(self):
        self.metrics = None
        self.target, text, end = None, b"", time.monotonic() + START_S
        while self.target is None:
            ready, _, _ = select.select([self.process.stdout], [], [], max(0, end - time.monotonic()))
            more = os.read(self.process.stdout.fileno(), 4096) if ready else b""
            if not more:
                self.__exit__()
                raise RuntimeError(f"lucernad does not start: {text.decode()}")
            text += more
            for line in text.decode().split("\n")[:-1]:
                if line.startswith("metrics on "):
                    self.metrics = line.removeprefix("metrics on ").strip()
                if line.startswith("listening on "):
                    self.target = line.removeprefix("listening on ").strip()
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()

    def ask(self, *arguments, stdin=""):
        """The answer of `lucerna ARGUMENTS --json`."""
        outcome = subprocess.run(
            [self.build / "bin/lucerna", "--server", self.target, *map(str, arguments), "--json"],
            input=stdin, capture_output=True, text=True, timeout=COMMAND_S, env=self.environment, check=False,
        )
        if outcome.returncode != 0:
            raise RuntimeError(f"lucerna {' '.join(map(str, arguments))}: {outcome.stderr}")
        return json.loads(outcome.stdout)
