"""Calls of the system and the heap that fail, and kills, at any moment of a command: it says so in one line or does its
work, and files are the old or the new ones, whole.

FAULTS_EACH says how many calls of a job are tried, a sample; 0 tries all of them, as `scripts/soak faults` does, and
prints how each kind of fault ended, as rows of a Markdown table. FAULTS_JOBS names the jobs, all by default."""
import collections
import os
import random
import signal
import subprocess
import tempfile
import time
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from proxima_program import PROXIMA, SANITIZED, SECONDS, ProgramTest, has_signal

SHIM = os.environ["FAULT_SHIM"]
EACH = int(os.environ.get("FAULTS_EACH", "40"))  # calls of a job that are tried; 0: all
SEED = int(os.environ.get("FAULTS_SEED", random.randrange(1 << 30)))

TETRAHEDRON = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
OLD = b"the old content"
# What glibc fills memory with that is not written yet or free again, all of it: whoever reads that gets nonsense each time.
GARBAGE = {"MALLOC_PERTURB_": "165", "GLIBC_TUNABLES": "glibc.malloc.tcache_count=0"}
# Each with its outputs; {f} is the folder.
JOBS = {
    "octree": ("octree {f}/a.off --depth 3 --save {f}/a.pxo --out {f}/a.vtu --json {f}/a.json", ["a.pxo", "a.vtu"]),
    "index": ("index {f}/a.off --lists --signs --save {f}/a.pxi --json {f}/a.json", ["a.pxi"]),
    "closest": ("closest {f}/a.off --point 0.1,0.2,3 --signed --out {f}/a.csv", ["a.csv"]),
    "saved": ("closest {f}/saved.pxi --point 0.1,0.2,3 --out {f}/a.npy", ["a.npy"]),
    "raycast": ("raycast {f}/a.off --ray 0,0,5,0,0,-1 --out {f}/a.csv", ["a.csv"]),
    "intersect": ("intersect {f}/a.off {f}/a.off --pose 0.3,0,0 --out {f}/a.csv", ["a.csv"]),
    "touch": ("touch {f}/a.off --device hand:press --seconds 0.02 --free-running --record {f}/a.pxt", ["a.pxt"]),
    "repair": ("repair {f}/a.off --out {f}/b.ply --map {f}/map.csv", ["b.ply", "map.csv"]),
}
JOBS = {name: JOBS[name] for name in os.environ.get("FAULTS_JOBS", " ".join(JOBS)).split()}


class FaultTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.random = random.Random(SEED)

    def prepare(self, name):
        folder = Path(tempfile.mkdtemp(dir=self.folder))
        (folder / "a.off").write_text(TETRAHEDRON)
        if name == "saved":
            subprocess.run([PROXIMA, "index", folder / "a.off", "--save", folder / "saved.pxi", "--quiet"], check=True)
        for output in JOBS[name][1]:
            (folder / output).write_bytes(OLD)
        return folder

    def run_job(self, name, folder, call, at=0, action="fail"):
        command, _ = JOBS[name]
        faults = {"LD_PRELOAD": SHIM, "FAULT_CALL": call, "FAULT_AT": str(at), "FAULT_ACTION": action,
                  "FAULT_COUNT": str(folder / "count"), **GARBAGE}
        # One thread: so the same call comes at the same place.
        return subprocess.run([PROXIMA, *command.format(f=folder).split(), "--threads", "1", "--quiet"], text=True,
                              capture_output=True, timeout=SECONDS, env={**os.environ, **faults}, check=False)

    def reference(self, name, call):
        """How many calls there are without a fault, and what the outputs are."""
        folder = self.prepare(name)
        result = self.run_job(name, folder, call)
        self.assertEqual(result.returncode, 0, result.stderr)
        return int((folder / "count").read_text()), [(folder / output).read_bytes() for output in JOBS[name][1]]

    def try_calls(self, call, action="fail", each=EACH):
        ended = collections.Counter()
        for name in JOBS:
            count, new = self.reference(name, call)
            self.assertGreater(count, 0)
            numbers = range(1, count + 1)
            if each and count > each:
                numbers = self.random.sample(numbers, each)

            def attempt(number, name=name, new=new):
                folder = self.prepare(name)
                result = self.run_job(name, folder, call, number, action)
                # Without memory nothing more is said.
                wrong = self.check(name, folder, result, new, says_what_was_written=call != "allocate")
                return number, wrong, result.returncode

            with ThreadPoolExecutor(os.cpu_count()) as pool:
                for number, wrong, status in pool.map(attempt, numbers):
                    ended["wrong" if wrong else "done" if status == 0 else "said" if status > 0 else "killed"] += 1
                    with self.subTest(job=name, call=call, number=number, of=count, seed=SEED):
                        self.assertIsNone(wrong)
        # Faults came: each kill ends its command; some failures make no difference, but not all.
        if action == "kill":
            self.assertEqual(ended["killed"], ended.total())
        else:
            self.assertGreater(ended["said"], 0)
        if EACH == 0:
            columns = (ended.total(), *(ended[how] for how in ("said", "done", "killed", "wrong")))
            print(f"| `{call}` {'fails' if action == 'fail' else 'is killed'} | {' | '.join(map(str, columns))} |", flush=True)

    def check(self, name, folder, result, new, says_what_was_written):
        """What is wrong, if anything."""
        outputs = [(folder / output).read_bytes() for output in JOBS[name][1]]
        if any(output not in (OLD, whole) for output, whole in zip(outputs, new)):
            return "an output is neither the old nor the new one"
        if result.returncode < 0:
            return None if self.may_be_killed(folder, result) else f"ended by signal {-result.returncode}: {result.stderr}"
        left = [path.name for path in folder.glob(".proxima-*")]
        if left:
            return f"{left} left behind"
        if result.returncode == 0:
            return None if outputs == new else "status 0, but an output is missing"
        if result.returncode not in (1, 2):
            return f"status {result.returncode}: {result.stderr}"
        if not result.stderr.startswith("proxima: ") or result.stderr.count("\n") != 1:
            return f"no line that says why: {result.stderr!r}"
        unsaid = [path for path, output in zip(JOBS[name][1], outputs) if output != OLD and f"{folder}/{path}" not in result.stderr]
        if says_what_was_written and unsaid:
            return f"{unsaid} written, and not said: {result.stderr!r}"
        return None

    def may_be_killed(self, _folder, _result):
        return False


@unittest.skipIf(SANITIZED, "sanitizers bring allocators of their own")
class Allocations(FaultTest):
    def test_each_fails_once(self):
        self.try_calls("allocate")


class Writes(FaultTest):
    def test_each_call_fails_once(self):
        for call in ("open", "write", "fsync", "close", "rename"):
            self.try_calls(call)
        self.try_calls("stat", each=min(EACH, 10))

    def test_outputs_that_were_written_before_a_failure_are_named(self):
        folder = self.prepare("repair")
        result = subprocess.run([PROXIMA, "repair", folder / "a.off", "--out", folder / "b.ply", "--map", folder / "map.csv",
                                 "--json", "/dev/full", "--quiet"], text=True, capture_output=True, timeout=SECONDS)
        self.assertEqual((result.returncode, result.stderr), (1, "proxima: /dev/full: cannot write this file: No space left on device; before "
                                                                 f"that, {folder}/b.ply, {folder}/map.csv had been written\n"))

    def test_what_a_link_leads_to_keeps_its_mode_where_it_cannot_be_looked_at(self):
        """As where the system does not let another user's link in /tmp be followed."""
        folder = self.prepare("closest")
        victim = folder / "victim"
        at = 0
        while True:
            victim.write_bytes(OLD)
            victim.chmod(0o600)
            (folder / "a.csv").unlink()
            (folder / "a.csv").symlink_to(victim)
            at += 1
            result = self.run_job("closest", folder, "stat", at)
            self.assertEqual(victim.stat().st_mode & 0o777, 0o600, at)
            self.assertEqual(result.returncode == 0, victim.read_bytes() != OLD, result.stderr)
            if at > int((folder / "count").read_text()):
                break
        self.assertGreater(at, 3)

    def test_a_failure_after_the_file_was_replaced_is_called_that(self):
        count, new = self.reference("closest", "fsync")
        folder = self.prepare("closest")
        result = self.run_job("closest", folder, "fsync", count)  # the last one is of the folder
        self.assertEqual(result.returncode, 1)
        self.assertIn("has been replaced", result.stderr)
        self.assertEqual((folder / "a.csv").read_bytes(), new[0])


class Kills(FaultTest):
    def test_at_each_call(self):
        for call in ("open", "write", "fsync", "close", "rename"):
            self.try_calls(call, "kill")

    def test_at_random_moments(self):
        """Of a command that replaces the same file again and again: what a power cut or an impatient user does. Every other
        kill waits for the save, which is too short to be met by chance."""
        command = [PROXIMA, "index", "icosphere:3", "--lists", "--save", self.folder / "a.pxi", "--quiet"]
        begin = time.monotonic()
        subprocess.run(command, check=True)
        seconds = time.monotonic() - begin
        whole = (self.folder / "a.pxi").read_bytes()
        ended = collections.Counter()
        saving = 0
        for attempt in range(EACH or 1000):
            (self.folder / "a.pxi").write_bytes(OLD)
            before = self.temporary()
            process = subprocess.Popen(command)
            if attempt % 2 == 0:
                time.sleep(self.random.uniform(0, 1.2 * seconds))
            else:
                while process.poll() is None and self.temporary() <= before:
                    pass
                time.sleep(self.random.uniform(0, 0.003))
            process.kill()
            killed = process.wait() == -signal.SIGKILL
            after = (self.folder / "a.pxi").read_bytes()
            self.assertIn(after, (OLD, whole) if killed else (whole,), f"seed {SEED}")
            ended["killed" if killed else "done"] += 1
            saving += bool(killed and self.temporary() - before)
        self.assertGreater(saving, 0, f"seed {SEED}: no kill was within a save")
        subprocess.run(command, check=True)
        self.assertEqual(self.temporary(), set(), "the last run clears up")
        if EACH == 0:
            columns = (ended.total(), 0, ended["done"], ended["killed"], 0)
            print(f"| killed at a random moment of a save | {' | '.join(map(str, columns))} |", flush=True)

    def temporary(self):
        """The files that saves have begun."""
        return set(self.folder.glob(".proxima-*"))

    def may_be_killed(self, folder, result):
        """By the shim; the next command that writes there clears up."""
        if result.returncode != -signal.SIGKILL:
            return False
        subprocess.run([PROXIMA, "repair", folder / "a.off", "--out", folder / "next.off", "--quiet"], check=True)
        return not list(folder.glob(".proxima-*")) and (folder / "next.off").exists()


CLOSED_STDOUT = "proxima: standard output: cannot write: Bad file descriptor; the output is incomplete\n"


class Streams(ProgramTest):
    """Standard streams that are closed when the program starts."""

    def shell(self, command):
        return subprocess.run(["sh", "-c", command], text=True, capture_output=True, timeout=SECONDS, cwd=self.folder,
                              env={**os.environ, "P": PROXIMA}, check=False)

    def test_a_closed_stderr_is_no_reason_to_end(self):
        for command in ("$P closest missing.off --point 0,0,0 2>&-", "$P nonsense 2>&-",
                        "$P closest missing.off --point 0,0,0 2>/dev/full"):
            self.assertIn(self.shell(command).returncode, (1, 2), command)
        result = self.shell("$P octree icosphere:4 --save a.pxo --progress --quiet 2>&-")
        self.assertEqual(result.returncode, 0)

    def test_a_stderr_that_nobody_reads_is_no_reason_to_end(self):
        for arguments, status in ((("closest", "missing.off", "--point", "0,0,0"), 1), (("nonsense",), 2),
                                  (("index", "icosphere:4", "--save", "a.pxi", "--progress", "--quiet"), 0)):
            reads, writes = os.pipe()
            os.close(reads)
            result = subprocess.run([PROXIMA, *arguments], cwd=self.folder, stderr=writes, timeout=SECONDS)
            os.close(writes)
            self.assertEqual(result.returncode, status, arguments)
        self.assertTrue((self.folder / "a.pxi").exists())

    def test_what_is_meant_for_a_closed_stream_does_not_go_into_a_file(self):
        self.file("a.off", TETRAHEDRON)
        os.mkfifo(self.folder / "points")
        process = subprocess.Popen(["sh", "-c", "exec \"$P\" closest a.off --points points --out a.csv <&- >&- 2>&-"],
                                   cwd=self.folder, env={**os.environ, "P": PROXIMA})
        with open(self.folder / "points", "w") as points:  # returns once the program reads
            streams = [os.readlink(f"/proc/{process.pid}/fd/{stream}") for stream in range(3)]
            points.write("0,0,2\n")
        self.assertEqual(streams, ["/dev/null"] * 3)
        self.assertEqual(process.wait(timeout=SECONDS), 1, "stdout is closed")
        self.assertEqual((self.folder / "a.csv").read_text().count("\n"), 2)
        result = self.shell("$P closest a.off --point 0,0,2 --out b.csv >&-")
        self.assertEqual(result.returncode, 1)
        self.assertIn("standard output", result.stderr)
        self.assertEqual((self.folder / "b.csv").read_text().count("\n"), 2)
        for words in ("--help", "--version", "octree --help"):
            result = self.shell(f"$P {words} >&-")
            self.assertEqual((result.returncode, result.stderr), (1, CLOSED_STDOUT))

    def test_an_ignored_interrupt_stays_ignored(self):
        os.mkfifo(self.folder / "points")
        process = subprocess.Popen(["sh", "-c", "trap '' INT; exec \"$P\" closest cube --points points --out a.csv --quiet"],
                                   cwd=self.folder, env={**os.environ, "P": PROXIMA})
        with open(self.folder / "points", "w") as points:  # returns once the program reads
            self.assertTrue(has_signal(process.pid, "SigCgt", signal.SIGTERM), "no handlers yet")
            self.assertTrue(has_signal(process.pid, "SigIgn", signal.SIGINT))
            process.send_signal(signal.SIGINT)
            points.write("0,0,2\n")
        self.assertEqual(process.wait(timeout=SECONDS), 0)
        self.assertTrue((self.folder / "a.csv").exists())


if __name__ == "__main__":
    if EACH == 0:
        print("| Fault | Times | Ended with a line that says why | Did its work all the same | Killed, files whole | Wrong |")
        print("|---|---:|---:|---:|---:|---:|", flush=True)
    unittest.main()
