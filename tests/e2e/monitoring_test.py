#!/usr/bin/python3
"""What a real lucernad reports of itself: metrics, statistics, log.

    tests/e2e/monitoring_test.py BUILD_DIR

Debian's prometheus scrapes the server and evaluates the alerts and the queries of deploy/prometheus.  Skips what needs
prometheus where it is not installed.
"""
import json
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

import grpc

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from server_process import ServerProcess  # noqa: E402

DEPLOY = ROOT / "deploy/prometheus"
REFERENCE = ROOT / "tests/data/reference"
PATIENCE_S = 600  # ends tests that hang


def get(url):
    with urllib.request.urlopen(url, timeout=PATIENCE_S) as answer:
        return answer.read().decode()


def samples(text):
    """The values of a page of metrics, by name with labels."""
    return {line.rsplit(" ", 1)[0]: float(line.rsplit(" ", 1)[1])
            for line in text.splitlines() if not line.startswith("#")}


def families(text):
    return {line.split()[2]: line.split()[3] for line in text.splitlines() if line.startswith("# TYPE ")}


def promtool(*arguments, stdin=None):
    return subprocess.run(["promtool", *map(str, arguments)], input=stdin, capture_output=True, text=True,
                          timeout=PATIENCE_S, check=False)


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Metrics(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = ServerProcess(BUILD, REFERENCE, "--metrics", "127.0.0.1:0", "--memory-budget", "1GiB").__enter__()
        cls.addClassCleanup(cls.server.__exit__)
        for _ in range(3):
            cls.server.ask("load", "point.pbrt")
        cls.server.ask("sample", "point.pbrt", "--point", "0,0,0", "--normal", "0,0,1", "--samples", 5)
        cls.server.ask("render", "point.pbrt", "--samples", 1, "-o", pathlib.Path(cls.enterClassContext(
            tempfile.TemporaryDirectory()), "a.pfm"))

    def test_count_calls(self):
        page = samples(get(self.server.metrics))
        self.assertEqual(page['lucerna_calls_total{call="SampleLi",code="OK"}'], 1)
        self.assertEqual(page['lucerna_calls_total{call="LoadScene",code="INTERNAL"}'], 0)
        self.assertEqual(page['lucerna_samples_total{call="SampleLi"}'], 5)
        self.assertEqual(page["lucerna_scenes"], 1)
        self.assertEqual(page["lucerna_scene_builds_total"], 1)
        self.assertGreaterEqual(page["lucerna_scene_hits_total"], 2)
        self.assertEqual(page["lucerna_memory_budget_bytes"], 2**30)
        self.assertGreater(page['lucerna_scene_bytes{part="lights"}'], 0)
        self.assertGreater(page["process_resident_memory_bytes"], 1e6)

    def test_equal_the_statistics_over_grpc(self):
        stats = self.server.ask("top", "--once")
        page = samples(get(self.server.metrics))
        for call in stats["calls"]:
            name = call["method"].rsplit("/", 1)[1]
            if name != "GetStats":  # it counts itself after it has answered
                self.assertEqual(page[f'lucerna_calls_total{{call="{name}",code="OK"}}'], int(call["succeeded"]), name)
                self.assertAlmostEqual(page[f'lucerna_call_cpu_seconds_total{{call="{name}"}}'], call["cpuS"])
        self.assertEqual(sum(v for k, v in page.items() if k.startswith("lucerna_scene_bytes{")),
                         int(stats["sceneBytes"]))

    def test_each_has_a_row_in_the_page(self):
        rows = set(re.findall(r"^\| `((?:lucerna|process)_[a-z_]+)`", (ROOT / "docs/monitoring.md").read_text(), re.M))
        served = {n for n in families(get(self.server.metrics)) if not n.startswith("exposer_")}
        self.assertEqual(rows, served)

    def test_only_the_page_of_metrics_is_served(self):
        with self.assertRaises(urllib.error.HTTPError) as refused:
            get(self.server.metrics.replace("/metrics", "/"))
        self.assertEqual(refused.exception.code, 404)

    def test_a_busy_port_is_an_error(self):
        port = urllib.parse.urlsplit(self.server.metrics).port
        second = subprocess.run([BUILD / "bin/lucernad", "--listen", "127.0.0.1:0", "--metrics", f"127.0.0.1:{port}"],
                                capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(second.returncode, 1)
        self.assertIn(f"cannot serve metrics on 127.0.0.1:{port}: address in use", second.stderr)

    def test_doctor_finds_all_well(self):
        report = self.server.ask("doctor")
        self.assertTrue(report["well"])
        self.assertEqual([c["name"] for c in report["checks"]],
                         ["connection", "TLS", "token", "health", "version", "fingerprint", "limits", "clock", "descriptors",
                          "interactive queue", "bulk queue", "memory", "scenes"])
        self.assertIn("point.pbrt", report["checks"][-1]["text"])

    def doctor(self, target):
        """The checks that the doctor made, by name; the last one has failed."""
        out = subprocess.run([BUILD / "bin/lucerna", "doctor", "--json", "--server", target], capture_output=True,
                             text=True, timeout=PATIENCE_S, check=False, env=self.server.environment)
        report = json.loads(out.stdout)
        self.assertEqual(out.returncode, 1)
        self.assertFalse(report["well"])
        self.assertEqual([c["name"] for c in report["checks"] if not c["ok"]], [report["checks"][-1]["name"]])
        return {c["name"]: c["text"] for c in report["checks"]}

    def test_doctor_says_why_a_server_cannot_be_reached(self):
        self.assertEqual(self.doctor(f"127.0.0.1:{free_port()}"), {"connection": "no server listens there"})
        self.assertIn("no-such-host.invalid has no address", self.doctor("no-such-host.invalid:1")["connection"])
        # A program that speaks another protocol.
        checks = self.doctor(urllib.parse.urlsplit(self.server.metrics).netloc)
        self.assertEqual(list(checks), ["connection", "gRPC"])
        self.assertIn("no answer, so another program may listen there", checks["gRPC"])

    def test_top_shows_the_calls(self):
        out = subprocess.run([BUILD / "bin/lucerna", "top", "--once", "--server", self.server.target],
                             capture_output=True, text=True, timeout=PATIENCE_S, check=True)
        self.assertRegex(out.stdout, r"(?m)^LoadScene +[0-9.]+ ")
        self.assertRegex(out.stdout, r"(?m)^bulk +0 +0 ")
        # Live: two tables, then the signal.
        live = subprocess.Popen([BUILD / "bin/lucerna", "top", "--every", "10ms", "--server", self.server.target],
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        seen = 0
        for line in live.stdout:
            seen += line.startswith("lucernad at ")
            if seen == 2:
                live.send_signal(signal.SIGINT)
                seen = 3
        self.assertEqual(seen, 3)
        self.assertEqual(live.wait(PATIENCE_S), 130)
        live.stdout.close()

    @unittest.skipUnless(shutil.which("promtool"), "promtool is not installed")
    def test_have_the_form_of_prometheus(self):
        # The library's own metrics do not follow the naming rules.
        page = "\n".join(l for l in get(self.server.metrics).splitlines() if "exposer_" not in l) + "\n"
        self.assertIn("lucerna_calls_total", page)
        checked = promtool("check", "metrics", stdin=page)
        self.assertEqual(checked.stderr + checked.stdout, "")
        self.assertEqual(checked.returncode, 0)


@unittest.skipUnless(shutil.which("prometheus") and shutil.which("promtool"), "prometheus is not installed")
class Prometheus(unittest.TestCase):
    def test_the_alerts_are_right(self):
        for command in (["check", "config", DEPLOY / "prometheus.yml"],
                        ["test", "rules", DEPLOY / "lucernad.rules.test.yml"]):
            out = promtool(*command)
            self.assertEqual(out.returncode, 0, out.stdout + out.stderr)

    def queries(self):
        """The queries of the dashboard, as Grafana would send them."""
        dashboard = json.loads((DEPLOY / "dashboard.json").read_text())
        for panel in dashboard["panels"]:
            for target in panel["targets"]:
                yield target["expr"].replace("$__rate_interval", "1m").replace("$instance", ".*")

    def test_scrapes_a_server(self):
        with ServerProcess(BUILD, REFERENCE, "--metrics", "127.0.0.1:0") as server, \
                tempfile.TemporaryDirectory() as folder:
            server.ask("load", "point.pbrt")
            config = pathlib.Path(folder, "prometheus.yml")
            config.write_text((DEPLOY / "prometheus.yml").read_text()
                              .replace("127.0.0.1:9464", urllib.parse.urlsplit(server.metrics).netloc)
                              .replace("15s", "1s")
                              .replace("[lucernad.rules.yml]", f"[{DEPLOY / 'lucernad.rules.yml'}]"))
            port = free_port()
            prometheus = subprocess.Popen(
                ["prometheus", f"--config.file={config}", f"--storage.tsdb.path={folder}/data",
                 f"--web.listen-address=127.0.0.1:{port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                self.examine(f"http://127.0.0.1:{port}/api/v1/", server)
            finally:
                prometheus.send_signal(signal.SIGTERM)
                prometheus.wait(PATIENCE_S)

    def ask(self, api, query):
        try:
            answer = json.loads(get(api + "query?" + urllib.parse.urlencode({"query": query})))
        except urllib.error.HTTPError as error:
            if error.code == 503:
                raise  # prometheus is starting
            self.fail(f"{query}: {error.read().decode()}")
        return answer["data"]["result"]

    def examine(self, api, server):
        end = time.monotonic() + PATIENCE_S
        found = []
        while not found and time.monotonic() < end:
            try:
                found = self.ask(api, 'lucerna_calls_total{call="LoadScene",code="OK"}')
            except urllib.error.URLError:
                pass  # prometheus is starting
            time.sleep(0.2)
        self.assertEqual([f["value"][1] for f in found], ["1"])
        self.assertEqual(self.ask(api, 'up{job="lucernad"}')[0]["value"][1], "1")
        rules = json.loads(get(api + "rules"))["data"]["groups"][0]["rules"]
        self.assertEqual({r["lastError"] if "lastError" in r else "" for r in rules}, {""})
        # A query of a metric that does not exist has no answer.  Rates need two scrapes.
        left = set(self.queries())
        self.assertGreater(len(left), 15)
        server.ask("load", "--upload", REFERENCE / "point.pbrt")
        while left and time.monotonic() < end:
            server.ask("irradiance", "point.pbrt", "--point", "0,0,0", "--normal", "0,0,1")
            left = {q for q in left if not self.ask(api, q)}
            time.sleep(0.2)
        self.assertEqual(left, set())


class Log(unittest.TestCase):
    def run_with(self, *arguments, calls):
        """The lines that the server logs during `calls(channel)`."""
        with tempfile.TemporaryFile("w+") as log:
            with ServerProcess(BUILD, REFERENCE, *arguments, log=log) as server, \
                    grpc.insecure_channel(server.target) as channel:
                calls(channel)
            log.seek(0)
            return log.read().splitlines()

    @staticmethod
    def send(channel, method, request, metadata=()):
        try:
            channel.unary_unary(method)(request, metadata=metadata, timeout=PATIENCE_S)
        except grpc.RpcError:
            pass

    def test_has_a_line_of_json_for_each_call(self):
        def calls(channel):
            self.send(channel, "/lucerna.v1.AdminService/GetServerInfo", b"", [("x-request-id", "my-id")])
            self.send(channel, "/lucerna.v1.SceneService/GetScene", b"\x0a\x06secret")
            self.send(channel, "/lucerna.v1.SceneService/GetScene", b"\x0a\x02\xff\xfe")
        lines = self.run_with("--log-format", "json", calls=calls)
        parsed = [json.loads(line) for line in lines]
        self.assertEqual([(p["call"], p["code"]) for p in parsed if "call" in p],
                         [("GetServerInfo", "OK"), ("GetScene", "NOT_FOUND"), ("GetScene", "INVALID_ARGUMENT")])
        self.assertIn("my-id", [p.get("id") for p in parsed])
        self.assertNotIn("secret", "".join(lines))

    def test_is_limited_under_a_flood_of_malformed_messages(self):
        # Texts that are not UTF-8: Protobuf reports each one to the log of the process.
        def calls(channel):
            for _ in range(3000):
                self.send(channel, "/lucerna.v1.SceneService/GetScene", b"\x0a\x02\xff\xfe")
        lines = self.run_with("--log-lines", "5", calls=calls)
        of_calls = [line for line in lines if "call GetScene" in line]
        self.assertGreaterEqual(len(of_calls), 5)
        self.assertLess(len(lines), 1000)
        self.assertFalse([line for line in lines if "libprotobuf" in line])

    def test_has_no_line_of_a_library(self):
        picture = (REFERENCE / "tiles.png").read_bytes()
        with tempfile.TemporaryDirectory() as root, tempfile.TemporaryFile("w+") as log:
            scene = pathlib.Path(root, "scene.pbrt")
            scene.write_text('WorldBegin Texture "t" "spectrum" "imagemap" "string filename" "t.png"\n'
                             'Material "diffuse" "texture reflectance" "t" Shape "sphere"\n')
            with ServerProcess(BUILD, root, "--log-format", "json", log=log) as server:
                for kept in (20, 40, len(picture) // 2):  # libpng prints what is wrong with each
                    pathlib.Path(root, "t.png").write_bytes(picture[:kept])
                    server.ask("load", "scene.pbrt")  # the texture is grey
            log.seek(0)
            parsed = [json.loads(line) for line in log]
        self.assertEqual([p["code"] for p in parsed if p.get("call") == "LoadScene"], 3 * ["OK"])

    def test_has_no_calls_above_its_level(self):
        def calls(channel):
            self.send(channel, "/lucerna.v1.AdminService/GetServerInfo", b"")
        self.assertEqual(self.run_with("--log-level", "warning", calls=calls), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
