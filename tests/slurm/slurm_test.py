#!/usr/bin/python3
"""Submits deploy/slurm/lucerna-render.sbatch like a user, on a Slurm cluster of three nodes.

Usage: slurm_test.py BUILD_DIR [unittest's own arguments]
"""
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from slurm_cluster import ENDS_WITH_US, SlurmCluster, wait_until

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "deploy/slurm/lucerna-render.sbatch"
SCENE = ROOT / "tests/data/reference/textured.pbrt"  # refers to a picture, which must be uploaded too
MOVING = ROOT / "scenes/moving.pbrt"
# Long enough to be interrupted, in pieces that are small enough for an interruption anywhere.
OPTIONS = ["--samples", "512", "--tile-size", "16"]


def picture_of_one_server(directory):
    """Bytes of the picture that a single server renders of SCENE from its own disk."""
    with open(directory / "alone", "w+") as out:
        server = subprocess.Popen(
            [*ENDS_WITH_US, "lucernad", "--listen", "127.0.0.1:0", "--scene-root", SCENE.parent],
            stdout=out, stderr=subprocess.DEVNULL)
        try:
            def target():
                return (directory / "alone").read_text().strip().removeprefix("listening on ")
            where = wait_until(target, 600, "lucernad's address")
            subprocess.run(["lucerna", "render", "--server", where, SCENE.name, *OPTIONS, "-o",
                            directory / "alone.pfm"], check=True, timeout=600, stdout=subprocess.DEVNULL)
        finally:
            server.terminate()
            server.wait(30)
    return (directory / "alone.pfm").read_bytes()


class SlurmTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = cls.enterClassContext(SlurmCluster())
        cls.expected = picture_of_one_server(cls.cluster.directory)

    def setUp(self):
        self.directory = pathlib.Path(tempfile.mkdtemp(dir=self.cluster.directory))
        self.began = time.monotonic()

    def tearDown(self):
        self.cluster.run("scancel", "--user", str(os.getuid()), check=False)
        wait_until(lambda: not self.cluster.run("squeue", "-h"), 600, "no job left")
        self.assertEqual(self.cluster.processes("lucernad"), [], "servers that outlived their job")

    def submit(self, *arguments, nodes=3, environment=(), options=("--exclusive",)):
        """Number of the job that runs the batch script with these settings."""
        return self.cluster.run(
            "sbatch", "--parsable", f"--nodes={nodes}", *options, "--output=%j.log",
            f"--export={','.join(['ALL', *environment])}", SCRIPT, *arguments, cwd=self.directory)

    def submit_picture(self, output="room.pfm", *more, **options):
        return self.submit(SCENE, "-o", output, *OPTIONS, *more, **options)

    def log(self, job):
        path = self.directory / f"{job}.log"
        return path.read_text() if path.exists() else ""

    def assert_resumed(self, job):
        """Expects that fewer samples were computed than the picture has."""
        width, height = map(int, self.expected.split(b"\n", 2)[1].split())
        computed = int(re.search(r" (\d+) samples, ", self.log(job))[1])
        self.assertLess(computed, width * height * int(OPTIONS[1]))

    def journal(self, job):
        return self.directory / f"lucerna-{job}.journal"

    def wait_until_it_renders(self, job):
        """Waits until the journal has a small part of the picture; it has more bytes per pixel."""
        enough = len(self.expected) // 20

        def enough_is_done():
            self.assertNotIn(self.cluster.job(job)["JobState"], ("COMPLETED", "FAILED"), self.log(job))
            return self.journal(job).exists() and self.journal(job).stat().st_size > enough
        wait_until(enough_is_done, 600, f"job {job} renders")

    def assert_ends(self, job, state):
        ended = self.cluster.wait_for(job, 600)
        self.assertEqual(ended, state, self.log(self.cluster.job(job)["JobId"]))

    def assert_same_bits(self, what, job, servers, output="room.pfm"):
        self.assert_equal_pictures(what, job, servers, [self.expected], [(self.directory / output).read_bytes()])

    def assert_equal_pictures(self, what, job, servers, expected, pictures):
        same = pictures == expected
        print(f"\n  {what}: job {job}, {servers} server{'s'[:servers != 1]}, {time.monotonic() - self.began:.1f} s "
              f"from submission to end, {'the same bits' if same else 'OTHER BITS'}", flush=True)
        self.assertTrue(same)

    def test_three_servers_render_the_picture_of_one(self):
        job = self.submit_picture()
        self.assert_ends(job, "COMPLETED")
        self.assertIn("3 of 3 servers", self.log(job))
        self.assert_same_bits("one picture", job, 3)
        self.assertFalse(self.journal(job).exists())
        self.assertEqual(self.log(job).count("got SIGTERM"), 3, "servers that got SIGTERM")

    def test_a_killed_server_does_not_stop_the_job(self):
        job = self.submit_picture()
        self.wait_until_it_renders(job)
        self.cluster.run("scancel", "--signal=KILL", f"{job}.1")
        self.assert_ends(job, "COMPLETED")
        self.assertIn("does not answer", self.log(job))
        self.assert_same_bits("a server killed", job, 3)

    def test_a_failed_node_does_not_stop_the_job(self):
        job = self.submit_picture()
        self.wait_until_it_renders(job)
        self.cluster.fail("n3")
        try:
            wait_until(lambda: (self.directory / "room.pfm").exists() and
                       (self.directory / "room.pfm").stat().st_size == len(self.expected), 60, "the picture")
            self.assertIn("does not answer", self.log(job))
            self.assert_same_bits("a node lost", job, 3)
        finally:
            self.cluster.repair("n3")
        self.assert_ends(job, "COMPLETED")

    def test_a_requeued_job_continues(self):
        job = self.submit_picture()
        self.wait_until_it_renders(job)
        self.cluster.run("scontrol", "requeue", job)
        self.assert_ends(job, "COMPLETED")
        self.assertEqual(self.cluster.job(job)["Restarts"], "1")
        self.assert_resumed(job)
        self.assert_same_bits("interrupted and requeued", job, 3)

    def test_all_servers_gone_ends_the_job(self):
        job = self.submit_picture(nodes=2)
        self.wait_until_it_renders(job)
        self.cluster.run("scancel", "--signal=KILL", f"{job}.0", f"{job}.1")
        self.assert_ends(job, "FAILED")
        self.assertEqual(self.cluster.job(job)["ExitCode"], "1:0")
        self.assertIn("all servers have ended", self.log(job))
        self.assertIn(f"resumes from: {self.journal(job)}\n", self.log(job))

    def test_another_job_continues_from_the_journal_of_a_timed_out_job(self):
        job = self.submit_picture(nodes=2)
        self.wait_until_it_renders(job)
        self.cluster.run("scancel", "--batch", "--signal=TERM", job)  # equals --signal=B:TERM@30
        self.assert_ends(job, "FAILED")
        self.assertIn("interrupted", self.log(job))
        self.assertNotIn("all servers have ended", self.log(job))
        self.assertIn(f"resumes from: {self.journal(job)}\n", self.log(job))
        # The scene has the same id whether it is uploaded or read by the server.
        again = self.submit(SCENE.name, "-o", "room.pfm", *OPTIONS, "--journal", self.journal(job), nodes=1,
                            environment=[f"LUCERNA_SCENE_ROOT={SCENE.parent}"])
        self.assert_ends(again, "COMPLETED")
        self.assert_resumed(again)
        self.assert_same_bits("resumed by another job", again, 1)

    def test_servers_that_do_not_start_are_named_and_left_out(self):
        program = self.directory / "lucernad"
        program.write_text("""#!/bin/sh
case $SLURMD_NODENAME in
  n1) echo no disk >&2; exit 1;;
  n2) exec sleep 100;;
esac
echo "given $*" >&2
PATH=${PATH#*:} exec lucernad "$@"
""")
        program.chmod(0o755)
        environment = (f"PATH={self.directory}:{self.cluster.environment['PATH']}",
                       "LUCERNA_START_SECONDS=3", f"LUCERNA_ASSET_DIR={self.directory}/assets",
                       "LUCERNAD_OPTIONS=--memory-budget 1GiB")
        job = self.submit_picture(environment=environment)
        self.assert_ends(job, "COMPLETED")
        self.assertIn("n1: no disk", self.log(job))
        self.assertIn("no server on n1: it has ended", self.log(job))
        self.assertIn("no server on n2: it does not answer within 3 s", self.log(job))
        self.assertIn("1 of 3 servers", self.log(job))
        self.assertRegex(self.log(job), r"n3: given --listen 127\.0\.0\.1:0 --insecure --threads 2 --scene-root \S+ "
                         rf"--asset-dir {self.directory}/assets --memory-budget 1GiB\n")
        self.assertTrue(any((self.directory / "assets").iterdir()), "uploaded files that stay")
        self.assert_same_bits("two servers missing", job, 1)
        job = self.submit_picture(nodes=2, environment=environment)
        self.assert_ends(job, "FAILED")
        self.assertIn("no server came up", self.log(job))

    def test_a_broken_scene_fails_the_job_and_says_where(self):
        (self.directory / "broken.pbrt").write_text('Camera "perspective"\nWorldBegin\nShape "torus"\n')
        job = self.submit("broken.pbrt", "-o", "room.pfm", nodes=2)
        self.assert_ends(job, "FAILED")
        self.assertEqual(self.cluster.job(job)["ExitCode"], "1:0")
        self.assertRegex(self.log(job), r"broken\.pbrt:3:1: .*torus")
        self.assertFalse((self.directory / "room.pfm").exists())

    def test_each_task_of_an_array_renders_a_frame(self):
        self.directory /= "50%off"  # this character occurs in the journals' pattern
        self.directory.mkdir()
        job = self.submit(MOVING, "--fps", "4", "-o", "frame.%04d.pfm", "--samples", "16", nodes=1,
                          options=("--array=1-4", "--cpus-per-task=1"))
        for frame in range(1, 5):
            self.assert_ends(f"{job}_{frame}", "COMPLETED")
        # A single job can also render all frames.
        whole = self.submit(MOVING, "--frames", "1-4", "--fps", "4", "-o", "whole.%04d.pfm", "--samples", "16",
                            nodes=1)
        self.assert_ends(whole, "COMPLETED")
        frames, expected = ([(self.directory / f"{name}.{n:04}.pfm").read_bytes() for n in range(1, 5)]
                            for name in ("frame", "whole"))
        self.assert_equal_pictures("four frames by an array job, and again by one job", job, 4, expected, frames)
        self.assertEqual(len(set(frames)), 4, "frames that differ")
        self.assertEqual(list(self.directory.glob("*.journal")), [])

    def test_it_runs_within_salloc(self):
        log = self.cluster.run("salloc", "--quiet", "--nodes=2", "--exclusive", "bash", SCRIPT, SCENE,
                               "-o", "room.pfm", *OPTIONS, cwd=self.directory)
        self.assertIn("2 of 2 servers", log)
        self.assert_same_bits("salloc", "of salloc", 2)


if __name__ == "__main__":
    build = pathlib.Path(sys.argv.pop(1)).resolve()
    os.environ["PATH"] = f"{build}/bin:{os.environ['PATH']}"
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))  # so that the cluster ends too
    unittest.main(verbosity=2)
