#!/usr/bin/python3
"""Checks what lucernad tells systemd, and the unit of deploy/systemd.

    tests/server/lucernad_systemd_test.py LUCERNAD
"""
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile

from lucernad import Lucernad, expect

WAIT_S = 600  # ends tests that hang
DEPLOY = pathlib.Path(__file__).resolve().parents[2] / "deploy/systemd"
WATCHDOG_US = 400_000


def tells_systemd_its_state(lucernad):
    with tempfile.TemporaryDirectory() as directory, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        path = str(pathlib.Path(directory, "notify"))
        systemd.bind(path)
        systemd.settimeout(WAIT_S)

        def wait_for(state):
            while (message := systemd.recv(4096).decode()) != state:
                expect(message in ("READY=1", "WATCHDOG=1"), f"{message}, expected {state}")

        with Lucernad(lucernad, environment={"NOTIFY_SOCKET": path, "WATCHDOG_USEC": str(WATCHDOG_US)}) as server:
            expect(systemd.recv(4096) == b"READY=1", "the first message is not READY=1")
            for _ in range(3):
                wait_for("WATCHDOG=1")
            server.process.send_signal(signal.SIGHUP)
            wait_for("RELOADING=1")
            wait_for("READY=1")
            # The connections of the watchdog do not count for long.
            wait_for("WATCHDOG=1")
            server.process.send_signal(signal.SIGTERM)
            wait_for("STOPPING=1")
            expect(server.process.wait(WAIT_S) == 0, f"exit status {server.process.returncode}")


def unit_is_valid(lucernad):
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        print("skipped: systemd-analyze is not installed")
        return
    with tempfile.TemporaryDirectory() as directory:
        unit = pathlib.Path(directory, "lucernad.service")
        text = (DEPLOY / "lucernad.service").read_text()
        expect("/usr/local/bin/lucernad " in text, "the unit does not start /usr/local/bin/lucernad")
        # The user of the unit exists on no machine of a test.
        text = text.replace("/usr/local/bin/lucernad ", f"{pathlib.Path(lucernad).resolve()} ")
        unit.write_text(text.replace("User=lucernad", "User=daemon").replace("Group=lucernad", "Group=daemon"))
        verified = subprocess.run([analyze, "verify", "--man=no", unit], capture_output=True, text=True, timeout=WAIT_S,
                                  check=False)
        expect(verified.returncode == 0 and "lucernad.service" not in verified.stderr, verified.stderr)
        # Exit status 1 if the exposure is higher than 2.0, given in tenths.
        secure = subprocess.run([analyze, "security", "--offline=true", "--threshold=20", unit], capture_output=True,
                                text=True, timeout=WAIT_S, check=False)
        expect(secure.returncode == 0, secure.stdout[-500:])


def settings_are_valid(lucernad):
    checked = subprocess.run([lucernad, "--config", DEPLOY / "lucernad.toml", "--check-config"], capture_output=True,
                             text=True, timeout=WAIT_S, check=False)
    expect(checked.returncode == 0, checked.stderr)


def main():
    lucernad = sys.argv[1]
    tells_systemd_its_state(lucernad)
    settings_are_valid(lucernad)
    unit_is_valid(lucernad)


main()
