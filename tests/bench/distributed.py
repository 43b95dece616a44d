#!/usr/bin/python3
"""Measures one picture on several servers, some of which are killed, halted, slowed or added.

    tests/bench/distributed.py BUILD_DIR [--repeats N] [--samples N] [--page docs/distributed.md]

Servers are real and pinned to processor cores, so that what survives has a capacity that is known:
A has a core of its own, B and C share another.  What a job would ideally take follows from the
times that the same picture takes on either core alone, in the same repeat.  Medians of all repeats.
With --page the table in that page is written anew.
"""
import argparse
import contextlib
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "tests/data/reference"
SCENE = "bounces.pbrt"
TILE = 16
DEADLINE_S = 300  # of any one job


class Server:
    """A lucernad on one core."""

    def __init__(self, build, core, port=0):
        self.command = ["taskset", "-c", str(core), str(build / "server/lucernad"), "--threads", "1",
                        "--scene-root", str(SCENES), "--listen"]
        self.start(port)

    def start(self, port=None):
        port = self.port if port is None else port
        self.process = subprocess.Popen([*self.command, f"127.0.0.1:{port}"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        line = self.process.stdout.readline()
        match = re.match(r"listening on (\S+):(\d+)", line)
        if not match:
            raise RuntimeError(f"lucernad did not start: {line!r}")
        self.port = int(match[2])
        self.target = f"{match[1]}:{match[2]}"

    def signal(self, number):
        self.process.send_signal(number)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def stop(self):
        if self.process.poll() is None:
            self.signal(signal.SIGCONT)
            self.kill()
        self.process.stdout.close()


class Job:
    """One `lucerna render`, begun at once."""

    def __init__(self, bench, servers, samples=None, extra=()):
        self.output = bench.scratch / "picture.pfm"
        self.output.unlink(missing_ok=True)
        names = servers if isinstance(servers, str) else ",".join(s.target for s in servers)
        self.begun = time.monotonic()
        self.process = subprocess.Popen(
            [str(bench.build / "client/lucerna"), "render", SCENE, "--servers", names,
             "--samples", str(samples or bench.samples), "--tile-size", str(TILE),
             "-o", str(self.output), *extra],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.said = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.said.append(line.strip())

    def wait_until_said(self, what):
        end = time.monotonic() + DEADLINE_S
        while not any(what in line for line in list(self.said)):
            if self.process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"the job did not say {what!r}: {self.said}")
            time.sleep(0.01)

    def sleep_until(self, seconds):
        time.sleep(max(0.0, self.begun + seconds - time.monotonic()))

    def finish(self):
        """The time it took, and its picture."""
        try:
            status = self.process.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        took = time.monotonic() - self.begun
        self.reader.join()
        if status != 0:
            raise RuntimeError(f"the job failed: {self.said}")
        return took, self.output.read_bytes()


class Bench:
    def __init__(self, build, samples, scratch):
        self.build, self.samples, self.scratch = build, samples, scratch
        self.picture = None
        self.same_bits = True
        cores = sorted(os.sched_getaffinity(0))
        if len(cores) < 2:
            raise SystemExit("needs two processor cores")
        self.core_a, self.core_b = cores[0], cores[1]

    @contextlib.contextmanager
    def servers(self, cores):
        running = []
        try:
            for core in cores:
                running.append(Server(self.build, core))
            yield running
        finally:
            for server in running:
                server.stop()

    def finish(self, job):
        took, picture = job.finish()
        self.picture = self.picture or picture
        self.same_bits = self.same_bits and picture == self.picture
        return took

    def alone(self, core):
        with self.servers([core]) as servers:
            return self.finish(Job(self, servers))

    def plain(self, cores):
        with self.servers(cores) as servers:
            return self.finish(Job(self, servers))

    def three(self, act):
        """A, B and C; `act` does something to A while the job runs."""
        with self.servers([self.core_a, self.core_b, self.core_b]) as servers:
            job = Job(self, servers)
            act(job, servers[0])
            return self.finish(job)

    def killed(self, at):
        def act(job, a):
            job.sleep_until(at)
            a.kill()
        return self.three(act)

    def halted(self, at):
        def act(job, a):
            job.sleep_until(at)
            a.signal(signal.SIGSTOP)
        return self.three(act)

    def restarted(self, at, back):
        def act(job, a):
            job.sleep_until(at)
            a.kill()
            job.sleep_until(back)
            a.start()
        return self.three(act)

    def slowed(self):
        """A works 10 ms in every 100."""
        ended = threading.Event()

        def throttle(a):
            while not ended.is_set():
                a.signal(signal.SIGSTOP)
                ended.wait(0.09)
                a.signal(signal.SIGCONT)
                time.sleep(0.01)

        with self.servers([self.core_a, self.core_b, self.core_b]) as servers:
            job = Job(self, servers)
            thread = threading.Thread(target=throttle, args=(servers[0],))
            thread.start()
            try:
                return self.finish(job)
            finally:
                ended.set()
                thread.join()

    def added(self, at):
        names = self.scratch / "servers"
        with self.servers([self.core_b, self.core_b]) as servers:
            names.write_text("".join(s.target + "\n" for s in servers))
            job = Job(self, f"@{names}")
            job.sleep_until(at)
            with self.servers([self.core_a]) as more:
                with names.open("a") as file:
                    file.write(more[0].target + "\n")
                return self.finish(job)

    def all_gone(self, at):
        """From when the servers are back to the end."""
        with self.servers([self.core_a, self.core_b]) as servers:
            job = Job(self, servers)
            job.sleep_until(at)
            for server in servers:
                server.kill()
            job.wait_until_said("no server answers: waiting")
            for server in servers:
                server.start()
            back = time.monotonic()
            self.finish(job)
            return time.monotonic() - back

    def attempts_at_a_dead_server(self, seconds):
        """Connections to an address where each is accepted and closed, while a job waits for it."""
        with socket.create_server(("127.0.0.1", 0)) as listener:
            listener.settimeout(0.2)
            job = Job(self, f"127.0.0.1:{listener.getsockname()[1]}")
            count = 0
            while time.monotonic() < job.begun + seconds:
                with contextlib.suppress(TimeoutError):
                    listener.accept()[0].close()
                    count += 1
            job.process.kill()
            job.process.wait()
            job.reader.join()
            return count

    def client_cost(self):
        """CPU [us] of the client a piece, and its memory [MiB], for pieces of one pixel."""
        with self.servers([self.core_a, self.core_b]) as servers:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            job = Job(self, servers, samples=1, extra=["--tile-size", "1"])
            pid, _, usage = os.wait4(job.process.pid, 0)
            job.process.returncode = 0
            job.reader.join()
            del before, pid
            data = job.output.read_bytes()
            width, height = map(int, data.split(b"\n", 2)[1].split())
            return 1e6 * (usage.ru_utime + usage.ru_stime) / (width * height), usage.ru_maxrss / 1024, width * height


def ideal(changes):
    """When one picture is done by what makes `rate` pictures a second from each (time, rate) on."""
    left = 1.0
    for (begin, rate), (end, _) in zip(changes, [*changes[1:], (float("inf"), 0)]):
        if left <= rate * (end - begin):
            return begin + left / rate
        left -= rate * (end - begin)
    raise AssertionError


def measure(bench, repeats):
    rows = {}

    def add(name, figure, value):
        rows.setdefault(name, (figure, []))[1].append(value)

    for _ in range(repeats):
        alone_a, alone_b = bench.alone(bench.core_a), bench.alone(bench.core_b)
        a, b = 1 / alone_a, 1 / alone_b
        full = 1 / (a + b)
        at, back = 0.3 * full, 0.3 * full + 2
        two = bench.plain([bench.core_a, bench.core_b])
        add("2 servers of one core against 1 of one core: times as fast", "at least 1.9",
            (alone_a + alone_b) / 2 / two)
        add("one server alone on a core [s]", "", (alone_a + alone_b) / 2)

        def compare(name, took, best, factor, slack=""):
            add(f"{name}: took [s]", "", took)
            add(f"{name}: ideal [s]", "", best)
            add(f"{name}: took / ideal", f"at most {factor}{slack}", took / best)

        compare("kill -9 one of three", bench.killed(at), ideal([(0, a + b), (at, b)]), 1.2, ", plus 2 s")
        compare("SIGSTOP one of three", bench.halted(at), ideal([(0, a + b), (at, b)]), 1.2, ", plus 2 s")
        compare("restart one of three after 2 s", bench.restarted(at, back),
                ideal([(0, a + b), (at, b), (back, a + b)]), 1.2, ", plus 2 s")
        compare("add one to two", bench.added(at), ideal([(0, b), (at, a + b)]), 1.2, ", plus 2 s")
        compare("one of three slowed to a tenth", bench.slowed(), 1 / (a / 10 + b), 1.1)
        compare("all gone, then back: from then on", bench.all_gone(at), (1 - 0.3) * full, 1.2, ", plus 2 s")
        print(".", end="", flush=True, file=sys.stderr)
    print(file=sys.stderr)
    result = [(name, figure, statistics.median(values), min(values), max(values))
              for name, (figure, values) in rows.items()]
    dead = bench.attempts_at_a_dead_server(60)
    result.append(("attempts at a dead server in its first minute", "fewer than 50", dead, dead, dead))
    cpu, memory, pieces = bench.client_cost()
    result.append((f"client's CPU a piece of one pixel [us], of {pieces}", "", cpu, cpu, cpu))
    result.append(("client's memory with them [MiB]", "", memory, memory, memory))
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--page", type=pathlib.Path)
    options = parser.parse_args()
    if not shutil.which("taskset"):
        raise SystemExit("needs taskset (util-linux)")
    with tempfile.TemporaryDirectory() as scratch:
        bench = Bench(options.build.resolve(), options.samples, pathlib.Path(scratch))
        rows = measure(bench, options.repeats)
    lines = ["| | asked for | median | least | most |", "|---|---|---|---|---|"]
    lines += [f"| {name} | {figure} | {median:.3g} | {least:.3g} | {most:.3g} |"
              for name, figure, median, least, most in rows]
    lines.append(f"| all pictures above | the same bits | {'the same bits' if bench.same_bits else 'DIFFERENT'} | | |")
    table = "\n".join(lines)
    print(table)
    if options.page:
        page = options.page.read_text()
        begin, end = "<!-- measured -->\n", "<!-- /measured -->\n"
        head, rest = page.split(begin)
        tail = rest.split(end)[1]
        options.page.write_text(head + begin + table + "\n" + end + tail)
    if not bench.same_bits:
        raise SystemExit("pictures differ")


if __name__ == "__main__":
    main()
