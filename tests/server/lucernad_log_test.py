#!/usr/bin/python3
"""Checks what lucernad logs at its start and how it reports errors.

    tests/server/lucernad_log_test.py LUCERNAD
"""
import fcntl
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

import grpc

ANSWER_S = 60  # a server that waits for its log never answers
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


def calls_are_answered_though_nobody_reads_the_log(lucernad):
    read, write = os.pipe()
    fcntl.fcntl(write, fcntl.F_SETPIPE_SZ, 4096)  # is full after some lines
    server = subprocess.Popen([lucernad, "--listen", "127.0.0.1:0", "--threads", "2", "--log-lines", "0"],
                              stdout=subprocess.PIPE, stderr=write, text=True)
    os.close(write)
    try:
        address = server.stdout.readline().removeprefix("listening on ").strip()
        with grpc.insecure_channel(address) as channel:
            call = channel.unary_unary("/grpc.health.v1.Health/Check")
            for _ in range(300):
                call(b"", timeout=ANSWER_S, wait_for_ready=True)
            log = os.read(read, 65536).decode()
            expect(log.endswith("\n"), f"a line is cut: {log[-200:]}")
            while "lines were left out" not in log:
                call(b"", timeout=ANSWER_S)  # each writes what waits
                log += os.read(read, 65536).decode()
        for line in log.splitlines():
            expect(re.fullmatch(LINE, line), f"no whole line: {line}")
        server.send_signal(signal.SIGTERM)
        expect(server.wait(ANSWER_S) == 0, f"exit code {server.returncode}")
    finally:
        server.kill()
        server.wait()
        server.stdout.close()
        os.close(read)


def refused(lucernad, *arguments):
    """The errors of a server that does not start."""
    run = subprocess.run([lucernad, *arguments], capture_output=True, text=True)
    expect(run.returncode in (1, 2), f"{arguments}: exit code {run.returncode}")
    expect(run.stderr.startswith("lucernad: "), f"{arguments}: {run.stderr}")


def main():
    lucernad = sys.argv[1]
    served(lucernad)
    calls_are_answered_though_nobody_reads_the_log(lucernad)
    refused(lucernad, "--threads", "many")
    refused(lucernad, "--threads", "5000")
    refused(lucernad, "--no-such-option")
    refused(lucernad, "--listen", "nowhere")
    refused(lucernad, "--listen", "127.0.0.1:0", "--scene-root", "/no/such/directory")


main()
