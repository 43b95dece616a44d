#!/usr/bin/python3
"""Checks the limits of connections, and that lucernad survives a lack of file descriptors.

    tests/server/lucernad_connections_test.py LUCERNAD
"""
import resource
import select
import socket
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request

import grpc
from lucernad import Lucernad, expect

HEALTH = "/grpc.health.v1.Health/Check"
WAIT_S = 600  # ends tests that hang
PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + b"\0\0\0\4\0\0\0\0\0"  # with empty SETTINGS
MAX_CONCURRENT_STREAMS = 3  # number of the setting in RFC 9113


def files(most):
    """A function for the server's process that limits its open files."""
    return {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))}


def connect(server, source="127.0.0.1"):
    connection = socket.create_connection(("127.0.0.1", server.port), WAIT_S, (source, 0))
    connection.settimeout(WAIT_S)
    return connection


def is_open(connection):
    """Whether the server serves the connection: it answers the start of HTTP/2."""
    try:
        connection.sendall(PREFACE)
        return connection.recv(1) != b""
    except (ConnectionResetError, BrokenPipeError):
        return False


def ends(connection):
    """Waits until the server closes the connection."""
    try:
        while connection.recv(4096):
            pass
    except ConnectionResetError:
        pass


def serves(server):
    """Whether a new client gets an answer."""
    with grpc.insecure_channel(server.address, [("grpc.use_local_subchannel_pool", 1)]) as channel:
        try:
            return channel.unary_unary(HEALTH)(b"", timeout=WAIT_S, wait_for_ready=True) == b"\x08\x01"
        except grpc.RpcError:
            return False


def serves_after_many_connections(lucernad):
    """gRPC's own accept loop stops for ever in this test (https://github.com/grpc/grpc/issues/20418)."""
    with Lucernad(lucernad, **files(64)) as server:
        connections = [connect(server) for _ in range(120)]
        opened = sum(is_open(c) for c in connections)
        expect(0 < opened < 64, f"{opened} of 120 connections are open, with 64 descriptors")
        for connection in connections:
            connection.close()
        expect(serves(server), "no new client is accepted")
        expect("max-connections = 4096, but the limit of open files, 64, leaves room for" in server.log(), server.log())


def too_few_descriptors_are_refused(lucernad):
    with tempfile.TemporaryDirectory() as root:
        run = subprocess.run([lucernad, "--listen", "127.0.0.1:0", "--scene-root", root, "--threads", "2"],
                             capture_output=True, text=True, timeout=WAIT_S, check=False, **files(30))
    expect(run.returncode == 1 and "the limit of open files is 30 (ulimit -n), allowed: at least" in run.stderr,
           f"{run.returncode}: {run.stderr}")


def connections_have_a_limit(lucernad):
    with Lucernad(lucernad, "--max-connections", 3) as server:
        held = [connect(server) for _ in range(3)]
        expect(all(is_open(c) for c in held), "a connection within the limit is refused")
        expect(not is_open(connect(server)), "a connection over the limit is open")
        server.wait_for_log("from 127.0.0.1: 3 connections are open, allowed: 3")
        held.pop().close()
        end = time.monotonic() + WAIT_S
        while not is_open(connect(server)):
            expect(time.monotonic() < end, "a closed connection still counts")
        for connection in held:
            connection.close()


def peers_have_a_limit(lucernad):
    with Lucernad(lucernad, "--max-peer-connections", 2) as server:
        held = [connect(server, "127.0.0.2") for _ in range(2)]
        expect(all(is_open(c) for c in held), "a connection within the limit is refused")
        expect(not is_open(connect(server, "127.0.0.2")), "a connection over the limit of its peer is open")
        server.wait_for_log("from 127.0.0.2: 2 connections of this peer are open, allowed: 2")
        other = connect(server, "127.0.0.3")
        expect(is_open(other), "another peer is refused")
        for connection in (*held, other):
            connection.close()


def silent_and_idle_connections_end(lucernad):
    with Lucernad(lucernad, "--handshake-seconds", 1, "--idle-seconds", 1) as server:
        silent = connect(server)
        ends(silent)
        idle = connect(server)
        expect(is_open(idle), "the connection is refused")
        ends(idle)
        silent.close()
        idle.close()
        expect(serves(server), "no new client is accepted")


def streams_have_a_limit(lucernad):
    with Lucernad(lucernad, "--max-streams", 7) as server:
        connection = connect(server)
        connection.sendall(PREFACE)
        with connection.makefile("rb") as stream:
            head = stream.read(9)
            length = int.from_bytes(head[:3], "big")
            expect(head[3] == 4, f"the first frame is no SETTINGS: {head}")
            payload = stream.read(length)
        settings = dict(struct.unpack_from(">HI", payload, at) for at in range(0, length, 6))
        expect(settings.get(MAX_CONCURRENT_STREAMS) == 7, f"{settings}")
        connection.close()


def metrics_answer_beside_half_requests(lucernad):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with Lucernad(lucernad, "--metrics", f"127.0.0.1:{port}"):
        halves = [socket.create_connection(("127.0.0.1", port), WAIT_S) for _ in range(20)]
        for half in halves:
            half.sendall(b"GET /metrics HTTP/1.1\r\n")
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=WAIT_S) as answer:
            expect(b"lucerna_" in answer.read(), "no metrics")
        # A scrape that waits is answered after the server has closed nearly all of them.
        closed = select.select(halves, [], [], 0)[0]
        expect(len(closed) < 10, f"the scrape waited until {len(closed)} half requests had ended")
        for half in halves:
            half.close()


def main():
    lucernad = sys.argv[1]
    serves_after_many_connections(lucernad)
    too_few_descriptors_are_refused(lucernad)
    connections_have_a_limit(lucernad)
    peers_have_a_limit(lucernad)
    silent_and_idle_connections_end(lucernad)
    streams_have_a_limit(lucernad)
    metrics_answer_beside_half_requests(lucernad)


main()
