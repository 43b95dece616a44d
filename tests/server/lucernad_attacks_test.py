#!/usr/bin/python3
"""Hostile clients without a token take neither the memory nor the threads of lucernad.

    tests/server/lucernad_attacks_test.py LUCERNAD LUCERNA
"""
import gzip
import os
import pathlib
import struct
import subprocess
import sys

from http2_frames import DATA, END_HEADERS, END_STREAM, HEADERS, RST_STREAM, Connection, frame, headers_of
from lucernad import Lucernad, expect

LUCERNAD, LUCERNA = sys.argv[1], sys.argv[2]
IRRADIANCE = "/lucerna.v1.LightingService/EstimateIrradiance"
REFLECTION = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"
CANCELLED = struct.pack(">I", 8)
COMMAND_S = 300  # ends tests that hang


def most_megabytes(server):
    """The largest resident memory so far."""
    status = pathlib.Path(f"/proc/{server.process.pid}/status").read_text()
    return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")) / 1024


def answers_others(server):
    run = subprocess.run([LUCERNA, "--server", server.address, "info"], capture_output=True, text=True, timeout=COMMAND_S,
                         check=False)
    expect(run.returncode == 0, f"info: {run.stderr}")


def unpacking_messages_are_refused(server):
    packed = gzip.compress(bytes(1 << 30))
    message = b"\1" + struct.pack(">I", len(packed)) + packed
    client = Connection(server.port)
    stream = client.stream()
    client.send(frame(HEADERS, END_HEADERS, stream, headers_of(IRRADIANCE, ("grpc-encoding", "gzip"))))
    for i in range(0, len(message), 16384):
        client.send(frame(DATA, 0, stream, message[i:i + 16384]))
    client.send(frame(DATA, END_STREAM, stream))
    answers_others(server)
    expect(most_megabytes(server) < 300, f"{most_megabytes(server):.0f} MB for a message that unpacks to 1 GiB")


def resets_close_the_connection(server):
    for path in (IRRADIANCE, "/lucerna.v1.RenderService/RenderImage", "/lucerna.v1.SceneService/UploadAsset"):
        client, sent = Connection(server.port), 0
        while not client.closed and sent < 1000000:
            calls = (client.stream() for _ in range(100))
            client.send(b"".join(frame(HEADERS, END_HEADERS, s, headers_of(path)) + frame(RST_STREAM, 0, s, CANCELLED)
                                 for s in calls))
            sent += 100
        expect(client.closed, f"{path}: {sent} calls were reset, and the connection is open")
        answers_others(server)
    server.wait_for_log("more than 1000 calls were cancelled")


def reflection_has_few_threads(server):
    clients = [Connection(server.port) for _ in range(4)]
    for client in clients:
        client.send(b"".join(frame(HEADERS, END_HEADERS, client.stream(), headers_of(REFLECTION)) for _ in range(500)))
    answers_others(server)
    threads = len(os.listdir(f"/proc/{server.process.pid}/task"))
    expect(threads < 150, f"{threads} threads for 2000 streams of reflection")
    for client in clients:
        client.socket.close()


for attack in (unpacking_messages_are_refused, resets_close_the_connection, reflection_has_few_threads):
    with Lucernad(LUCERNAD) as lucernad:
        attack(lucernad)
