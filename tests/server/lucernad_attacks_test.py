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

from http2_frames import (CONTINUATION, DATA, END_HEADERS, END_STREAM, HEADERS, RST_STREAM, Connection, frame,
                          headers_of, literal)
from lucernad import Lucernad, expect

LUCERNAD, LUCERNA = sys.argv[1], sys.argv[2]
DATA_ROOT = pathlib.Path(__file__).parents[1] / "data" / "reference"
IRRADIANCE = "/lucerna.v1.LightingService/EstimateIrradiance"
SAMPLE_LE = "/lucerna.v1.LightingService/SampleLe"
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
    for path in (IRRADIANCE, "/lucerna.v1.RenderService/RenderImage", "/lucerna.v1.SceneService/UploadAsset",
                 "/grpc.health.v1.Health/Check", "/grpc.health.v1.Health/Watch", REFLECTION, "/no.such/Call"):
        client, sent = Connection(server.port), 0
        while not client.closed and sent < 1000000:
            calls = (client.stream() for _ in range(100))
            client.send(b"".join(frame(HEADERS, END_HEADERS, s, headers_of(path)) + frame(RST_STREAM, 0, s, CANCELLED)
                                 for s in calls))
            sent += 100
        expect(client.closed, f"{path}: {sent} calls were reset, and the connection is open")
        answers_others(server)
    server.wait_for_log("more than 1000 calls were cancelled", count=7)
    expect(most_megabytes(server) < 400, f"{most_megabytes(server):.0f} MB for calls that were reset")


def reflection_needs_no_threads(server):
    before = len(os.listdir(f"/proc/{server.process.pid}/task"))
    clients = [Connection(server.port) for _ in range(4)]
    for client in clients:
        client.send(b"".join(frame(HEADERS, END_HEADERS, client.stream(), headers_of(REFLECTION)) for _ in range(500)))
    answers_others(server)
    threads = len(os.listdir(f"/proc/{server.process.pid}/task"))
    expect(threads < before + 30, f"{threads} threads for 2000 streams of reflection, {before} before")
    for client in clients:
        client.socket.close()


def headers_without_end_close_the_connection(server):
    client, sent = Connection(server.port), 0
    client.send(frame(HEADERS, 0, client.stream(), headers_of(IRRADIANCE)))
    block = literal("x-a", "b" * 100) * 150
    while sent < 1 << 30 and client.send(frame(CONTINUATION, 0, client.next - 2, block) * 50):
        sent += 50 * len(block)
    expect(client.closed, f"{sent} bytes of headers were sent, and the connection is open")
    expect(most_megabytes(server) < 600, f"{most_megabytes(server):.0f} MB for {sent} bytes of headers")
    answers_others(server)


def answers_that_nobody_takes_are_refused(server):
    run = subprocess.run([LUCERNA, "--server", server.address, "load", "point.pbrt"], capture_output=True, text=True,
                         timeout=COMMAND_S, check=False)
    scene = run.stdout[:64].encode()
    message = b"\x0a\x40" + scene + b"\x18\x80\x80\x04"  # scene_id, count = 65536: 4 MB
    message = b"\0" + struct.pack(">I", len(message)) + message
    client = Connection(server.port, window=0)
    for _ in range(200):
        stream = client.stream()
        client.send(frame(HEADERS, END_HEADERS, stream, headers_of(SAMPLE_LE)) + frame(DATA, END_STREAM, stream, message))
    server.wait_for_log("call SampleLe", count=100)
    answers_others(server)
    server.wait_for_log("code=RESOURCE_EXHAUSTED")
    expect(most_megabytes(server) < 400, f"{most_megabytes(server):.0f} MB for answers that nobody takes")


def requests_that_never_arrive_end(server):
    client, stream = Connection(server.port), 1
    half = frame(HEADERS, END_HEADERS, client.stream(), headers_of(IRRADIANCE)) + frame(DATA, 0, stream, b"\0\0\0\1\0half")
    client.send(half)
    server.wait_for_log("code=DEADLINE_EXCEEDED")
    server.wait_for_log("call EstimateIrradiance")


ATTACKS = {unpacking_messages_are_refused: (), resets_close_the_connection: (), reflection_needs_no_threads: (),
           headers_without_end_close_the_connection: (),
           answers_that_nobody_takes_are_refused: ("--scene-root", DATA_ROOT),
           requests_that_never_arrive_end: ("--idle-seconds", 1)}
for attack, options in ATTACKS.items():
    with Lucernad(LUCERNAD, *options) as lucernad:
        attack(lucernad)
