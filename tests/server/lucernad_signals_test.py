#!/usr/bin/python3
"""Checks what signals do to lucernad.

    tests/server/lucernad_signals_test.py LUCERNAD
"""
import hashlib
import signal
import sys
import time

import grpc
from lucernad import Lucernad, expect

UPLOAD = "/lucerna.v1.SceneService/UploadAsset"
HEALTH = "/grpc.health.v1.Health/Check"
WAIT_S = 600  # ends tests that hang


def serves(channel):
    return channel.unary_unary(HEALTH)(b"", timeout=WAIT_S, wait_for_ready=True) == b"\x08\x01"


def hold_call(channel):
    """Begins an upload that never ends.  Returns when the server runs it."""
    digest = hashlib.sha256(b"12345678").digest()
    header = b"\x0a\x20" + digest + b"\x10\x08"  # sha256 and size_bytes of AssetHeader
    request = b"\x0a" + bytes([len(header)]) + header

    def requests():
        yield request
        time.sleep(WAIT_S)

    call, end = None, time.monotonic() + WAIT_S
    while time.monotonic() < end:
        if call is None or call.done():  # the probe below may come first
            call = channel.stream_unary(UPLOAD).future(requests())
        try:
            channel.stream_unary(UPLOAD)(iter([request]), timeout=WAIT_S)
        except grpc.RpcError as error:
            # Another stream sends this file.
            if error.code() == grpc.StatusCode.FAILED_PRECONDITION and not call.done():
                return call
        time.sleep(0.01)
    sys.exit("lucernad_signals_test: the upload did not begin")


def survives(lucernad, number):
    with Lucernad(lucernad) as server, grpc.insecure_channel(server.address) as channel:
        server.process.send_signal(number)
        server.wait_for_log(f"got {signal.Signals(number).name}", WAIT_S)
        expect(serves(channel), f"lucernad does not serve after {number}")
        server.process.send_signal(signal.SIGTERM)
        expect(server.process.wait(WAIT_S) == 0, f"exit status {server.process.returncode}")


def second_signal_ends_the_drain(lucernad, second):
    with Lucernad(lucernad, "--drain-seconds", "86400") as server:
        with grpc.insecure_channel(server.address) as channel:
            call = hold_call(channel)
            server.process.send_signal(signal.SIGTERM)
            server.wait_for_log("draining for at most 86400 s", WAIT_S)
            expect(server.process.poll() is None, "lucernad did not drain")
            server.process.send_signal(second)
            expect(server.process.wait(WAIT_S) == 0, f"exit status {server.process.returncode}")
            expect(call.exception(WAIT_S) is not None, "the upload did not fail")


def main():
    lucernad = sys.argv[1]
    for number in (signal.SIGHUP, signal.SIGUSR1, signal.SIGUSR2):
        survives(lucernad, number)
    second_signal_ends_the_drain(lucernad, signal.SIGTERM)
    second_signal_ends_the_drain(lucernad, signal.SIGINT)


main()
