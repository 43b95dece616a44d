#!/usr/bin/python3
"""What lucerna prints and how it ends when a server is hostile or broken.

    tests/e2e/hostile_server_test.py BUILD_DIR STUBS_DIR

STUBS_DIR has Python's stubs of the API.  The server is a fake.
"""
import concurrent.futures
import csv
import importlib
import io
import itertools
import json
import math
import os
import pathlib
import re
import resource
import struct
import subprocess
import sys
import tempfile
import unittest

import grpc

BUILD, STUBS = (pathlib.Path(a).resolve() for a in sys.argv[1:3])
sys.path.insert(0, str(STUBS))
MODULES = [importlib.import_module(f"lucerna.v1.{name}_pb2") for name in ("admin", "lighting", "render", "scene")]
WAIT_S = 900  # ends tests that hang
# A title for the terminal, the C1 form of an escape, text from right to left, and a bell.
HOSTILE = "\x1b]0;owned\x07\x1b[2J \x9b31m \u202egnp.exe\u2066 \x7f\b\r \"quoted\", name"
OBEYED = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
POINT = ["--point", "0,0,0", "--normal", "0,0,1"]
COMMANDS = [["load", "x.pbrt"], ["inspect", "x.pbrt"], ["scenes"], ["scenes", "--available"], ["scene", "x.pbrt"],
            ["scene", "x.pbrt", "--remarks"], ["lights", "x.pbrt"], ["info"], ["top", "--once"], ["doctor"],
            ["leases"], ["lease", "x.pbrt", "--for", "9"], ["release", "x.pbrt"], ["power", "x.pbrt"],
            ["edit", "x.pbrt", "--remove", "1"], ["irradiance", "x.pbrt", *POINT],
            ["__complete", "lucerna", "load", ""]]


def fill(message, depth=0):
    """Puts the hostile text into every string, with one entry in each list."""
    for field in message.DESCRIPTOR.fields:
        repeated = field.label == field.LABEL_REPEATED
        if field.name in ("next_page_token", "missing"):
            continue
        if field.type == field.TYPE_STRING:
            if repeated:
                getattr(message, field.name).append(HOSTILE)
            else:
                setattr(message, field.name, HOSTILE)
        elif field.type == field.TYPE_MESSAGE and depth < 4 and field.containing_oneof is None:
            fill(getattr(message, field.name).add() if repeated else getattr(message, field.name), depth + 1)
    return message


class Fake(grpc.GenericRpcHandler):
    """Answers each call by `answer`, a function of the method's service, its name, the request and the context."""

    def __init__(self, answer):
        self.answer = answer

    def service(self, details):
        service, name = details.method.rpartition(".")[2].split("/")
        module = next(m for m in MODULES if service in m.DESCRIPTOR.services_by_name)
        method = module.DESCRIPTOR.services_by_name[service].methods_by_name[name]
        request, response = (getattr(module, t.name) for t in (method.input_type, method.output_type))

        def run(data, context):
            return self.answer(name, request.FromString(data), response(), context)
        kind = grpc.unary_stream_rpc_method_handler if name == "RenderImage" else grpc.unary_unary_rpc_method_handler
        return kind(run, response_serializer=lambda m: m.SerializeToString())

    def __enter__(self):
        self.server = grpc.server(concurrent.futures.ThreadPoolExecutor(8))
        self.server.add_generic_rpc_handlers((self,))
        self.target = f"127.0.0.1:{self.server.add_insecure_port('127.0.0.1:0')}"
        self.server.start()
        return self

    def __exit__(self, *_):
        self.server.stop(None).wait(WAIT_S)

    def run(self, *words, **more):
        return subprocess.run([str(BUILD / "bin/lucerna"), *words], capture_output=True, timeout=WAIT_S, check=False,
                              env=os.environ | {"LUCERNA_SERVER": self.target, "TERM": "xterm"}, **more)


def hostile_names(name, request, response, context):
    fill(response)
    if name == "EstimateIrradiance":
        items = len(request.receivers.offsets_m) // 3
        del response.shares[:]
        response.ClearField("item_costs")
        response.irradiance_lx[:] = [1] * 3 * items
        response.illuminance_lx[:] = response.zero_bound_lx[:] = response.unsampled_bound_lx[:] = [1] * items
        response.lower_lx[:] = response.upper_lx[:] = response.standard_error_lx[:] = [1] * items
        response.status[:] = [9] * items
    if name == "LoadScene":
        response.scene_id = "0" * 64
    return response


class Text(unittest.TestCase):
    def assert_plain(self, data, what):
        found = OBEYED.search(data.decode())
        self.assertIsNone(found, f"{what}: {data!r}")

    def test_no_name_reaches_the_terminal_raw(self):
        printed = 0
        with Fake(hostile_names) as fake:
            for words in COMMANDS:
                for form in ("table", "json", "csv"):
                    ran = fake.run("--output", form, *words) if words[0] != "__complete" else fake.run(*words)
                    for data in (ran.stdout, ran.stderr):
                        self.assert_plain(data, f"{words} {form}")
                        printed += b"owned" in data
                    if form == "json" and words[0] != "__complete":
                        json.loads(ran.stdout)
                    if form == "csv" and ran.returncode == 0 and words[0] != "__complete":
                        rows = list(csv.reader(io.StringIO(ran.stdout.decode()), strict=True))
                        self.assertEqual({len(row) for row in rows}, {len(rows[0])}, words)
        self.assertGreater(printed, 20)

    def test_programs_print_by_print_h_alone(self):
        root = pathlib.Path(__file__).resolve().parents[2] / "client"
        printing = re.compile(r"fmt::print|std::(cout|cerr|puts|fputs|fwrite|printf|putchar)\b")
        files = {str(f.relative_to(root)) for f in (*root.rglob("*.cpp"), *root.rglob("*.h"))
                 if printing.search(re.sub("//.*", "", f.read_text()))}
        self.assertEqual(files, {"terminal/print.h"})

    def test_json_means_what_the_server_sent(self):
        with Fake(hostile_names) as fake:
            self.assertEqual(json.loads(fake.run("--json", "scenes").stdout)["scenes"][0]["path"], HOSTILE)

    def test_no_error_reaches_the_terminal_raw(self):
        def fail(name, request, response, context):
            context.abort(grpc.StatusCode.NOT_FOUND, HOSTILE)
        with Fake(fail) as fake:
            for words in COMMANDS[:-1]:
                for form in ("table", "json"):
                    ran = fake.run("--output", form, *words)
                    self.assertIn(b"owned", ran.stdout + ran.stderr, words)
                    self.assert_plain(ran.stdout + ran.stderr, f"{words} {form}")
                    if form == "json":
                        json.loads(ran.stderr or ran.stdout)


def short_answers(name, request, response, context):
    if name == "LoadScene":
        response.scene_id = "0" * 64
    return response


def picture_of(values):
    """A server whose pictures have one tile with these three doubles; it never stops sending it."""
    def answer(name, request, response, context):
        if name != "RenderImage":
            return short_answers(name, request, response, context)
        tile = response.tile
        tile.rect.x1 = tile.rect.y1 = tile.image_width = tile.image_height = tile.block_count = 1
        tile.sum, tile.deviation = struct.pack("3d", *values), bytes(24)
        again = itertools.takewhile(lambda _: context.is_active(), itertools.repeat(response))
        return itertools.chain([response], again)
    return answer


class Answers(unittest.TestCase):
    def assert_broken(self, ran, what):
        self.assertEqual(ran.returncode, 1, ran)
        self.assertIn(b"the server broke the protocol: ", ran.stderr)
        self.assertIn(what, ran.stderr)

    def test_points_that_the_answer_lacks_are_an_error(self):
        with Fake(short_answers) as fake:
            self.assert_broken(fake.run("irradiance", "x.pbrt", *POINT), b"irradiance_lx: has 0 entries, must be 3")

    def test_pictures_are_finite_and_end(self):
        for values, what in (((1, math.nan, 1), b"not finite"), ((1, 1, 1), b"came again without more blocks")):
            with Fake(picture_of(values)) as fake, tempfile.TemporaryDirectory() as folder:
                self.assert_broken(fake.run("render", "x.pbrt", "-o", "x.pfm", cwd=folder), what)
                self.assertEqual(os.listdir(folder), [])

    def test_a_picture_takes_memory_for_the_pixels_that_came(self):
        def huge(name, request, response, context):
            picture_of((1, 1, 1))(name, request, response, context)
            if name == "RenderImage":
                response.tile.image_width = response.tile.image_height = 1 << 15
                return iter([response])
            return response
        limit = 3 << 30  # a number for each pixel has 4 GiB
        with Fake(huge) as fake, tempfile.TemporaryDirectory() as folder:
            for more in ([], ["--preview=0.1"]):
                ran = fake.run("render", "x.pbrt", "-o", "x.png", *more, cwd=folder,
                               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
                self.assert_broken(ran, b"the picture ended with 1 of 1073741824 pixels")
                self.assertEqual(os.listdir(folder), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
