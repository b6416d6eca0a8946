"""proxima-mpi that is interrupted, killed or out of memory: all ranks end, with one message where one can be printed."""
import os
import random
import signal
import subprocess
import unittest

from mpi_program import SECONDS, SEED, DistributedTest, command, faulty, messages, ranks_of, run


class Stopping(DistributedTest):
    def start(self):
        """A run that takes a while, once it is under way."""
        process = subprocess.Popen(command(2, "--progress", "octree", "torus:1500x1000", "--depth", 11), text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.kill)
        self.assertIn("proxima: ", process.stderr.readline())
        return process

    def expect_stopped(self, errors):
        self.assertEqual(len(messages(errors)), 1, errors)
        self.assertTrue(messages(errors)[0].endswith("was stopped on request"), errors)

    def test_interrupt_as_a_terminal_sends_it(self):
        process = self.start()
        process.send_signal(signal.SIGINT)
        out, errors = process.communicate(timeout=SECONDS)
        self.assertNotEqual(process.returncode, 0)
        if messages(errors):  # mpirun kills ranks that take more than a second to end
            self.expect_stopped(errors)
        self.assertEqual(out.count("triangles,"), 0)

    def test_interrupt_of_one_rank_stops_all(self):
        process = self.start()
        os.kill(ranks_of(process)[1], signal.SIGINT)
        out, errors = process.communicate(timeout=SECONDS)
        self.assertEqual(process.returncode, 128 + signal.SIGINT)
        self.expect_stopped(errors)
        self.assertEqual(out.count("triangles,"), 0)

    def test_a_killed_rank_ends_the_run(self):
        process = self.start()
        os.kill(ranks_of(process)[1], signal.SIGKILL)
        out, errors = process.communicate(timeout=SECONDS)
        self.assertEqual(process.returncode, 128 + signal.SIGKILL)
        self.assertIn("signal 9", errors)
        self.assertEqual(out.count("triangles,"), 0)


class Reaching(DistributedTest):
    def expect_line(self, result, says):
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
        self.assertIn(says, messages(result.stderr)[0])
        self.assertEqual(result.stdout.count("triangles,"), 0)

    def test_a_rank_that_never_answers(self):
        result = faulty("reach", "fail", "octree", "torus:9x9", "--wait", 0.5, ranks=2, rank=1)
        self.expect_line(result, "rank 0 stopped: it cannot reach all other ranks")

    def test_what_mpi_refuses(self):
        for rank, at in ((0, 1), (1, 4)):
            result = faulty("reduce", "fail", "octree", "torus:9x9", ranks=2, rank=rank, at=at)
            self.expect_line(result, f"rank {rank} stopped: MPI_ERR_COUNT")

    def test_times_to_wait_that_are_none(self):
        for text in ("0", "-1", "nan", "soon"):
            result = run(2, "octree", "torus:9x9", "--wait", text)
            self.assertEqual(result.returncode, 2, f"{text}: {result.stderr}")
            self.assertEqual(result.stderr.count("--wait"), 1, result.stderr)


class Memory(DistributedTest):
    def output(self, job, result):
        """What a run printed, without times, and wrote."""
        if job[0] != "octree":
            return result.stdout
        return self.figures(result.stdout), [(self.folder / name).read_bytes() for name in ("a.pxo", "a.pvtu", "a_0.vtu", "a_1.vtu")]

    def test_a_failed_allocation_ends_all_ranks_with_one_line(self):
        """Of a rank's own; what MPI and p4est do where theirs fail is up to them. A run that does with less memory has the same output."""
        chance = random.Random(SEED)
        ended = 0
        jobs = [["octree", "torus:30x20", "--depth", 6, "--save", self.folder / "a.pxo", "--out", self.folder / "a.pvtu"]]
        jobs += [[name, "torus:30x20", "--point", "1,2,3"] for name in ("closest", "sign")] + [["rays", "torus:30x20", "--ray", "0,0,5,0,0,-1"]]
        for job in jobs:
            rank = chance.randrange(2)
            whole = faulty("new", "fail", *job, ranks=2, rank=rank, at=0, count=self.folder / "count")
            self.assertEqual(whole.returncode, 0, whole.stderr)
            expected = self.output(job, whole)
            count = int((self.folder / "count").read_text())
            self.assertGreater(count, 100)
            for at in chance.sample(range(1, count + 1), 8 if job[0] == "octree" else 3):
                result = faulty("new", "fail", *job, ranks=2, rank=rank, at=at)
                with self.subTest(job=job[0], rank=rank, at=at, of=count, seed=SEED):
                    if result.returncode == 0:  # sorts do with less memory
                        self.assertEqual(self.output(job, result), expected)
                        continue
                    ended += 1
                    self.assertEqual(result.returncode, 1, result.stderr)
                    self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
                    self.assertIn("memory ran out", messages(result.stderr)[0])
                    if job[0] == "octree":
                        self.assertEqual((self.folder / "a.pxo").read_bytes(), expected[1][0])
        self.assertGreater(ended, 0, f"no run met its fault, seed {SEED}")


if __name__ == "__main__":
    unittest.main()
