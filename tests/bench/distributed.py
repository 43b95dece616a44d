#!/usr/bin/python3
"""Measures one picture on several servers, some of which are killed, halted, slowed down or added.

    tests/bench/distributed.py BUILD_DIR [--repeats N] [--samples N] [--page docs/distributed.md]

Servers are real and pinned to processor cores, so that the surviving servers have a known capacity:
A has a core of its own, B and C share another.  The ideal time of a job follows from the times of
the same picture on either core alone, in the same repeat.  Medians of all repeats.
With --page it writes the tables into that page.
"""
import argparse
import contextlib
import json
import os
import pathlib
import re
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
DEADLINE_S = 300  # of a single job


class Server:
    """A lucernad on one core."""

    def __init__(self, build, core, port=0):
        self.command = ["taskset", "-c", str(core), str(build / "bin/lucernad"), "--threads", "1",
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
    """One `lucerna render`, started at once."""

    def __init__(self, bench, servers, samples=None, tile=16):
        self.output = bench.scratch / "picture.pfm"
        self.output.unlink(missing_ok=True)
        names = servers if isinstance(servers, str) else ",".join(s.target for s in servers)
        self.begun = time.monotonic()
        self.process = subprocess.Popen(
            [str(bench.build / "bin/lucerna"), "render", SCENE, "--servers", names,
             "--samples", str(samples or bench.samples), "--tile-size", str(tile),
             "-o", str(self.output)],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.lines = []
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.lines.append(line.strip())

    def wait_until_printed(self, what):
        end = time.monotonic() + DEADLINE_S
        while not any(what in line for line in list(self.lines)):
            if self.process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"the job did not print {what!r}: {self.lines}")
            time.sleep(0.01)

    def sleep_until(self, seconds):
        time.sleep(max(0.0, self.begun + seconds - time.monotonic()))

    def finish(self):
        """Its time and its picture."""
        try:
            status = self.process.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        took = time.monotonic() - self.begun
        self.reader.join()
        if status != 0:
            raise RuntimeError(f"the job failed: {self.lines}")
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
        """Servers A, B and C; `act` disturbs A while the job runs."""
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
        """A runs for 10 of every 100 ms."""
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
        """Time from the return of the servers to the end."""
        with self.servers([self.core_a, self.core_b]) as servers:
            job = Job(self, servers)
            job.sleep_until(at)
            for server in servers:
                server.kill()
            job.wait_until_printed("no server answers: waiting")
            for server in servers:
                server.start()
            back = time.monotonic()
            self.finish(job)
            return time.monotonic() - back

    def attempts_at_a_dead_server(self, seconds):
        """Number of connections to an address that accepts and closes each, while a job waits for it."""
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
        """CPU time of the client per piece [us], its memory [MiB], and the number of pieces of one pixel."""
        with self.servers([self.core_a, self.core_b]) as servers:
            job = Job(self, servers, samples=1, tile=1)
            _, status, usage = os.wait4(job.process.pid, 0)
            job.process.returncode = os.waitstatus_to_exitcode(status)
            job.finish()
            width, height = map(int, job.output.read_bytes().split(b"\n", 2)[1].split())
            cpu_s = usage.ru_utime + usage.ru_stime
            return 1e6 * cpu_s / (width * height), usage.ru_maxrss / 1024, width * height


def ideal(changes):
    """Time at which one picture is done, at `rate` pictures per second from each (time, rate) on."""
    left = 1.0
    for (begin, rate), (end, _) in zip(changes, [*changes[1:], (float("inf"), 0)]):
        if left <= rate * (end - begin):
            return begin + left / rate
        left -= rate * (end - begin)
    raise AssertionError


CASES = {  # allowed: this factor times the ideal, plus this many seconds
    "kill -9 one of three": (1.2, 2),
    "SIGSTOP one of three": (1.2, 2),
    "restart one of three, 2 s after it was killed": (1.2, 2),
    "add one to two": (1.2, 2),
    "one of three slowed to a tenth": (1.1, 0),
}


def measure_cases(bench, repeats):
    """For each repeat: the speed-up of two servers over one, and (took, ideal) of each case."""
    speedups, cases, gone = [], {name: [] for name in CASES}, []
    for _ in range(repeats):
        alone_a, alone_b = bench.alone(bench.core_a), bench.alone(bench.core_b)
        a, b = 1 / alone_a, 1 / alone_b
        at = 0.3 / (a + b)
        took = [bench.killed(at), bench.halted(at), bench.restarted(at, at + 2), bench.added(at),
                bench.slowed()]
        best = [ideal([(0, a + b), (at, b)]), ideal([(0, a + b), (at, b)]),
                ideal([(0, a + b), (at, b), (at + 2, a + b)]), ideal([(0, b), (at, a + b)]),
                ideal([(0, a / 10 + b)])]
        for name, pair in zip(CASES, zip(took, best)):
            cases[name].append(pair)
        speedups.append((alone_a + alone_b) / 2 / bench.plain([bench.core_a, bench.core_b]))
        gone.append((bench.all_gone(at), 0.7 / (a + b)))
        print(".", end="", flush=True, file=sys.stderr)
    print(file=sys.stderr)
    return speedups, cases, gone


def spread(values, form="{:.2f}"):
    return f"{form.format(statistics.median(values))} ({form.format(min(values))} to {form.format(max(values))})"


def measured(bench, repeats):
    speedups, cases, gone = measure_cases(bench, repeats)
    dead = bench.attempts_at_a_dead_server(60)
    cpu_us, memory_mib, pieces = bench.client_cost()
    lines = [f"Medians of {repeats} repeats (least to most), {os.cpu_count()} cores; a job of "
             f"{bench.samples} samples a pixel.", "",
             "| | took [s] | ideal [s] | took / ideal | limit | within the limit |", "|---|---|---|---|---|---|"]
    for name, pairs in cases.items():
        factor, slack = CASES[name]
        kept = sum(took <= factor * best + slack for took, best in pairs)
        lines.append(f"| {name} | {spread([t for t, _ in pairs], '{:.1f}')} | "
                     f"{spread([i for _, i in pairs], '{:.1f}')} | "
                     f"{spread([t / i for t, i in pairs])} | {factor} x ideal"
                     f"{f' + {slack} s' if slack else ''} | {kept} of {len(pairs)} |")
    lines.append(f"| all killed, then restarted: time after the restart | {spread([t for t, _ in gone], '{:.1f}')} | "
                 f"{spread([i for _, i in gone], '{:.1f}')} | | reports that it waits, then continues | "
                 f"{len(gone)} of {len(gone)} |")
    lines += ["", "| | measured | target |", "|---|---|---|",
              f"| speed of 2 servers with one core each, relative to 1 server | {spread(speedups)} | at least 1.9 |",
              f"| attempts at a dead server in its first minute | {dead} | fewer than 50 |",
              f"| the client's CPU, {pieces} pieces of one pixel and one sample | {cpu_us:.0f} us a piece | |",
              f"| the client's peak memory with these pieces | {memory_mib:.0f} MiB | |",
              f"| all pictures of this page | {'the same bits' if bench.same_bits else 'DIFFERENT BITS'} | the same bits |"]
    return lines


def simulated(build, scratch):
    """Results of the simulation of a thousand servers."""
    report = scratch / "simulation.json"
    subprocess.run([str(build / "tests/client/client_test"), "--gtest_filter=JobSimulation.AThousand*",
                    f"--gtest_output=json:{report}"], check=True, stdout=subprocess.DEVNULL)
    test = json.loads(report.read_text())["testsuites"][0]["testsuite"][0]
    return ["| | |", "|---|---|",
            f"| reached, as a share of the ideal (target: at least 0.9) | {float(test['share_of_ideal']):.3f} |",
            f"| simulated time; servers that died during it | {float(test['simulated_s']):.0f} s; {test['deaths']} |",
            f"| duplicate results | {test['duplicates']} |",
            f"| the schedule's CPU | {float(test['schedule_us_per_piece']):.2f} us a piece |",
            f"| peak memory of schedule and simulator | {test['peak_rss_mib']} MiB |"]


def on_slurm(build):
    """Figures of the tests of the batch script on a Slurm cluster of three nodes."""
    test = subprocess.run([sys.executable, str(ROOT / "tests/slurm/slurm_test.py"), str(build)],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    found = re.findall(r"^  (.+): jobs? (.+?), (.+ servers?), ([0-9.]+) s .*, (the same bits|OTHER BITS)$",
                      test.stdout, re.MULTILINE)
    if test.returncode != 0 or not found:
        raise SystemExit(test.stdout)
    return ["| job | servers | from submission to end [s] | |", "|---|---|---|---|",
            *(f"| {what} | {servers.split()[0]} | {seconds} | {same} |"
              for what, _, servers, seconds, same in found)]


def write(page, name, lines):
    """Replaces the lines between the page's marks of that name."""
    begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->\n"
    head, rest = page.split(begin)
    return head + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--page", type=pathlib.Path, help="write the figures into this page")
    options = parser.parse_args()
    if not shutil.which("taskset"):
        raise SystemExit("needs taskset (util-linux)")
    with tempfile.TemporaryDirectory() as directory:
        scratch = pathlib.Path(directory)
        bench = Bench(options.build.resolve(), options.samples, scratch)
        sections = {"measured": measured(bench, options.repeats),
                    "simulated": simulated(bench.build, scratch), "slurm": on_slurm(bench.build)}
    for lines in sections.values():
        print("\n".join(lines), end="\n\n")
    if options.page:
        page = options.page.read_text()
        for name, lines in sections.items():
            page = write(page, name, lines)
        options.page.write_text(page)
    if not bench.same_bits:
        raise SystemExit("pictures differ")


if __name__ == "__main__":
    main()
