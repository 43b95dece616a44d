#!/usr/bin/python3
"""Checks what lucernad logs at its start and how it reports errors.

    tests/server/lucernad_log_test.py LUCERNAD
"""
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

LINE = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d \[(debug|info|warning|error)\] \S.*"


def expect(condition, text):
    if not condition:
        sys.exit(f"lucernad_log_test: {text}")


def served(lucernad):
    """The log of a server that starts and ends."""
    with tempfile.TemporaryDirectory() as root:
        for name in ("a.pbrt", "room/b.pbrt"):
            file = pathlib.Path(root, name)
            file.parent.mkdir(exist_ok=True)
            file.write_text("WorldBegin\n")
        server = subprocess.Popen(
            [lucernad, "--listen", "127.0.0.1:0", "--scene-root", root, "--load", "a.pbrt", "--threads", "2",
             "--memory-budget", "8GiB"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        address = server.stdout.readline().removeprefix("listening on ").strip()
        server.send_signal(signal.SIGTERM)
        _, log = server.communicate()
        expect(server.returncode == 0, f"exit code {server.returncode}: {log}")
        for line in log.splitlines():
            expect(re.fullmatch(LINE, line), f"no time with zone and level: {line}")
        for part in (f"listens on {address}", f"scene root {root}: 2 scene files, 1 scenes loaded", "2 threads",
                     "memory budget 8.0 GiB", "got SIGTERM"):
            expect(part in log, f"{part!r} is not in the log:\n{log}")


def refused(lucernad, *arguments):
    """The errors of a server that does not start."""
    run = subprocess.run([lucernad, *arguments], capture_output=True, text=True)
    expect(run.returncode in (1, 2), f"{arguments}: exit code {run.returncode}")
    expect(run.stderr.startswith("lucernad: "), f"{arguments}: {run.stderr}")


def main():
    lucernad = sys.argv[1]
    served(lucernad)
    refused(lucernad, "--threads", "many")
    refused(lucernad, "--threads", "5000")
    refused(lucernad, "--no-such-option")
    refused(lucernad, "--listen", "nowhere")
    refused(lucernad, "--listen", "127.0.0.1:0", "--scene-root", "/no/such/directory")


main()
