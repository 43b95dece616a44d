#!/usr/bin/python3
"""Checks lucernad behind the HAProxy of deploy/haproxy.  Skipped without HAProxy.

    tests/e2e/haproxy_test.py BUILD_DIR
"""
import hashlib
import os
import pathlib
import select
import shutil
import socket
import subprocess
import sys
import tempfile
import time

import grpc

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/server"))
from certificates import Authority  # noqa: E402
from lucernad import Lucernad, expect  # noqa: E402

WAIT_S = 600  # ends tests that hang
SKIPPED = 77
TOKEN = "a-secret-for-the-front-door"


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Door:
    """HAProxy in front of a server.  Leaving the `with` block stops it."""

    def __init__(self, program, server, certificate):
        self.port = free_port()
        environment = os.environ | {"LUCERNA_BIND": f"127.0.0.1:{self.port}", "LUCERNA_CERTIFICATE": str(certificate),
                                    "LUCERNA_SERVER": server.address}
        self.process = subprocess.Popen([program, "-db", "-f", ROOT / "deploy/haproxy/haproxy.cfg"],
                                        stderr=subprocess.DEVNULL, env=environment)

    def __enter__(self):
        end = time.monotonic() + WAIT_S
        while True:
            expect(self.process.poll() is None, "haproxy ended")
            try:
                socket.create_connection(("127.0.0.1", self.port), WAIT_S).close()
                return self
            except ConnectionRefusedError:
                expect(time.monotonic() < end, "haproxy does not listen")
                time.sleep(0.05)

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(WAIT_S)


def lucerna(build, door, authority, *arguments, token=None):
    environment = {k: v for k, v in os.environ.items() if not k.startswith("LUCERNA")}
    if token:
        environment["LUCERNA_TOKEN"] = token
    return subprocess.run([build / "bin/lucerna", "--server", f"127.0.0.1:{door.port}", "--tls-ca", authority.certificate,
                           *arguments], capture_output=True, text=True, timeout=WAIT_S, env=environment, check=False)


def connections_have_a_limit(door):
    """HAProxy closes the connections over its limit, and serves again when others have ended."""
    held, refused = [], 0
    for _ in range(80):
        try:
            held.append(socket.create_connection(("127.0.0.1", door.port), WAIT_S))
        except ConnectionResetError:  # closed before it was complete here
            refused += 1
    # A silent connection is readable only if HAProxy has closed it.
    closed, end = refused, time.monotonic() + WAIT_S
    while closed < 16 and time.monotonic() < end:
        closed = refused + len(select.select(held, [], [], 0)[0])
        time.sleep(0.05)
    # Connections of the calls before may still count.
    expect(16 <= closed <= 24, f"{closed} connections are closed, expected 16")
    for connection in held:
        connection.close()


def main():
    program = shutil.which("haproxy", path=os.environ["PATH"] + ":/usr/sbin")
    if program is None:
        print("skipped: haproxy is not installed")
        sys.exit(SKIPPED)
    build = pathlib.Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        directory = pathlib.Path(name)
        authority = Authority(directory, "authority")
        certificate, key = authority.issue("door")
        both = directory / "door-with-key.pem"
        both.write_bytes(certificate.read_bytes() + key.read_bytes())
        tokens = directory / "tokens.toml"
        digest = hashlib.sha256(TOKEN.encode()).hexdigest()
        tokens.write_text(f'[[token]]\nname = "me"\nsha256 = "{digest}"\nroles = ["query", "load"]\n')
        with Lucernad(build / "bin/lucernad", "--token-file", tokens, "--scene-root",
                      ROOT / "tests/data/reference") as server, Door(program, server, both) as door:
            # The scene's own 1024 samples take 10 s of processor time.  Renders have a low priority, so beside other
            # programs that would take minutes.
            rendered = lucerna(build, door, authority, "render", "point.pbrt", "--samples", "4", "-o",
                               directory / "point.png", token=TOKEN)
            expect(rendered.returncode == 0, f"a picture through the door: {rendered.stderr}")
            expect((directory / "point.png").stat().st_size > 0, "the picture is empty")
            stranger = lucerna(build, door, authority, "info")
            expect("unauthenticated: the call has no token" in stranger.stderr, f"without a token: {stranger.stderr}")
            credentials = grpc.ssl_channel_credentials(authority.certificate.read_bytes())
            with grpc.secure_channel(f"localhost:{door.port}", credentials) as channel:
                health = channel.unary_unary("/grpc.health.v1.Health/Check")(b"", timeout=WAIT_S)
                expect(health == b"\x08\x01", f"health: {health}")
                try:
                    channel.unary_unary("/other.Service/Call")(b"", timeout=WAIT_S)
                    sys.exit("haproxy_test: the door lets an unknown call in")
                except grpc.RpcError as error:
                    expect(error.code() == grpc.StatusCode.UNIMPLEMENTED and "front door" in error.details(), str(error))
            connections_have_a_limit(door)
            again = lucerna(build, door, authority, "info", token=TOKEN)
            expect(again.returncode == 0, f"after many connections: {again.stderr}")


main()
