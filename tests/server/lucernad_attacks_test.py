#!/usr/bin/python3
"""Hostile clients without a token take neither the memory nor the threads of lucernad.

    tests/server/lucernad_attacks_test.py LUCERNAD LUCERNA
"""
import os
import pathlib
import select
import struct
import subprocess
import sys
import threading
import time

from http2_attacks import ATTACKS, IRRADIANCE, call
from http2_frames import DATA, Connection, frame
from lucernad import Lucernad, expect

LUCERNAD, LUCERNA = sys.argv[1], sys.argv[2]
DATA_ROOT = pathlib.Path(__file__).parents[1] / "data" / "reference"
COMMAND_S = 300  # ends tests that hang
MOST_MEGABYTES = 400
# A byte of a header takes 160 bytes of memory, and on a busy machine the server looks later.
MOST_HEADER_MEGABYTES = 600
SETTLE_S = 2  # until gRPC has released what a closed connection sent


def most_megabytes(server):
    """The largest resident memory so far."""
    status = pathlib.Path(f"/proc/{server.process.pid}/status").read_text()
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")) / 1024


def ask(server, *command):
    """The output of `lucerna`."""
    run = subprocess.run([LUCERNA, "--server", server.address, *command], capture_output=True, text=True,
                         timeout=COMMAND_S, check=False)
    expect(run.returncode == 0, f"{command}: {run.stderr}")
    return run.stdout


def attack(server, name, most=MOST_MEGABYTES):
    """Attacks, and expects that others get answers and that the memory is bounded.  Returns the connections."""
    clients = ATTACKS[name](server.port, ask(server, "load", "point.pbrt")[:64])
    ask(server, "info")
    expect(most_megabytes(server) < most, f"{name}: {most_megabytes(server):.0f} MB")
    return clients


def attack_until_closed(server, name, reason):
    client, = attack(server, name)
    expect(client.closed, f"{name}: the connection is open")
    server.wait_for_log(reason)


def reflection_needs_no_threads(server):
    before = len(os.listdir(f"/proc/{server.process.pid}/task"))
    clients = attack(server, "reflection")
    threads = len(os.listdir(f"/proc/{server.process.pid}/task"))
    expect(threads < before + 30, f"{threads} threads for 2000 streams of reflection, {before} before")
    for client in clients:
        client.socket.close()


def answers_that_nobody_takes_are_refused(server):
    client, = attack(server, "unread_samples")
    server.wait_for_log("code=RESOURCE_EXHAUSTED")
    expect(not client.closed, "the connection is closed")


def large_requests_may_arrive_together(server):
    client = Connection(server.port)
    for _ in range(3):
        client.send(call(client, IRRADIANCE) + frame(DATA, 0, client.next - 2, b"\0" + struct.pack(">I", 60 << 20)))
        for stream in (0, client.next - 2):
            client.windows[stream] -= 5
    sent = client.send_data(range(1, client.next, 2), 35 << 20)
    ask(server, "info")
    time.sleep(SETTLE_S)
    if select.select([client.socket], [], [], 0)[0]:
        client.read()
    expect(sent == 3 * 35 << 20, f"the server took {sent} bytes")
    expect(not client.closed, "the connection is closed")


def requests_that_never_arrive_end(server):
    client = Connection(server.port)
    client.send(call(client, IRRADIANCE) + frame(DATA, 0, 1, b"\0\0\0\1\0half"))
    server.wait_for_log("code=DEADLINE_EXCEEDED")


def others_connect_during_a_long_header(server):
    """The attack lasts until the server closes its connection."""
    attacker = threading.Thread(target=ATTACKS["long_header"], args=(server.port,))
    attacker.start()
    time.sleep(1)
    ask(server, "info")
    expect(attacker.is_alive(), "a new connection waits for the header of another")


OPTIONS = ("--scene-root", DATA_ROOT, "--memory-budget", "200MiB")
with Lucernad(LUCERNAD, *OPTIONS) as lucernad:
    attack(lucernad, "packed_message")
for path in ("", "_of_pictures", "_of_uploads", "_of_checks", "_of_watches", "_of_reflection", "_of_unknown_calls"):
    with Lucernad(LUCERNAD, *OPTIONS) as lucernad:
        attack_until_closed(lucernad, "resets" + path, "its client cancels too many calls")
with Lucernad(LUCERNAD, *OPTIONS) as lucernad:
    referring, = attack(lucernad, "referring_headers", MOST_HEADER_MEGABYTES)
    expect(referring.closed, "referring headers: the connection is open")
    time.sleep(SETTLE_S)
    expect(most_megabytes(lucernad) < MOST_HEADER_MEGABYTES, f"referring headers: {most_megabytes(lucernad):.0f} MB")
with Lucernad(LUCERNAD, *OPTIONS) as lucernad:
    attack_until_closed(lucernad, "empty_frames_of_headers", "messages and headers are not complete")
for test in (reflection_needs_no_threads, answers_that_nobody_takes_are_refused,
             large_requests_may_arrive_together, others_connect_during_a_long_header):
    with Lucernad(LUCERNAD, *OPTIONS) as lucernad:
        test(lucernad)
with Lucernad(LUCERNAD, *OPTIONS, "--idle-seconds", 1) as lucernad:
    requests_that_never_arrive_end(lucernad)
