"""Runs proxima-mpi as its users do, and with calls that fail; the paths of the programs are in environment variables."""
import os
import random
import subprocess
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

PROXIMA, PROGRAM, MPIRUN = (os.environ[name] for name in ("PROXIMA", "PROXIMA_MPI", "MPIRUN"))
SECONDS = 200
# A run of the tests takes some of the cases, which the seed chooses; EVERY=1: all of them.
SEED = int(os.environ.get("SEED", random.randrange(1 << 30)))
EVERY = os.environ.get("EVERY") == "1"
print("seed", SEED, flush=True)
# Each process looks the machine up when it starts; the cores are all that is wanted of it.
os.environ.setdefault("HWLOC_COMPONENTS", "-pci,-linuxio,-opencl,-cuda,-nvml,-gl")
SESSIONS = tempfile.TemporaryDirectory()  # removed when the program ends


def command(ranks, *arguments):
    root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
    # Containers forbid the copies between processes that Open MPI would make by a system call; and it starts in less time with the
    # components alone that ranks on one machine need.
    options = {"btl_vader_single_copy_mechanism": "none", "pml": "ob1", "btl": "self,vader", "osc": "pt2pt", "coll": "tuned,basic,libnbc,self,inter",
               "plm": "isolated",
               # A run that ends removes the folder that all runs of a user share, while another one makes its own in it.
               "orte_tmpdir_base": tempfile.mkdtemp(dir=SESSIONS.name)}
    words = [word for option in options.items() for word in ("--mca", *option)]
    return [MPIRUN, *root, *words, "--oversubscribe", "-n", str(ranks), PROGRAM, *map(str, arguments)]


def run(ranks, *arguments):
    return subprocess.run(command(ranks, *arguments), capture_output=True, text=True, timeout=SECONDS)


def run_each(jobs):
    """Runs two at a time, for a run mostly waits for its processes to start and end; each job is the arguments of run()."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(lambda job: run(*job), jobs))


def run_apart(*ranks):
    """One rank for each folder and its arguments."""
    words = []
    for folder, arguments in ranks:
        one = command(1, *arguments)
        one[one.index(PROGRAM):one.index(PROGRAM)] = ["-wdir", str(folder)]
        words += [":", *one[one.index("-n"):]] if words else one
    return subprocess.run(words, capture_output=True, text=True, timeout=SECONDS)


def faulty(call, action, *arguments, ranks=3, rank=0, at=1, count=os.devnull):
    """A run in which one such call of one rank fails or kills it (tests/apps/fault_shim.cpp). MPI itself writes, but neither fsyncs nor renames, and has no C++."""
    shell = 'if [ "$OMPI_COMM_WORLD_RANK" = "$FAULT_RANK" ]; then export LD_PRELOAD="$FAULT_SHIM"; fi; exec "$@"'
    words = command(ranks, *arguments)
    words[words.index(PROGRAM):words.index(PROGRAM)] = ["bash", "-c", shell, "-"]
    faults = {"FAULT_RANK": str(rank), "FAULT_CALL": call, "FAULT_AT": str(at), "FAULT_ACTION": action, "FAULT_COUNT": str(count)}
    return subprocess.run(words, capture_output=True, text=True, timeout=SECONDS, env={**os.environ, **faults})


def on_a_full_disk(*arguments):
    """A run whose files may have no more than 100 KiB."""
    # Ranks that talk through files in memory would meet the limit before there is anything to save.
    words = command(3, *arguments)
    words[words.index("self,vader")] = "self,tcp"
    words[words.index(PROGRAM):words.index(PROGRAM)] = ["bash", "-c", 'ulimit -f 100; exec "$@"', "-"]
    return subprocess.run(words, capture_output=True, text=True, timeout=SECONDS, env={**os.environ, "PMIX_MCA_gds": "hash"})


def ranks_of(process):
    """The process numbers of the ranks of a run."""
    below = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return [int(number) for number in below if Path(f"/proc/{number}/comm").read_text().strip() == Path(PROGRAM).name[:15]]


def messages(text):
    return [line for line in text.splitlines() if line.startswith("proxima-mpi: ")]


def some(cases, count):
    """So many of the cases, in their order."""
    cases = list(cases)
    taken = range(len(cases)) if EVERY else sorted(random.Random(SEED).sample(range(len(cases)), count))
    return [cases[k] for k in taken]


def some_ranks():
    """Three, and one or four."""
    return (1, 3, 4) if EVERY else (3, random.Random(SEED).choice((1, 4)))


class DistributedTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def file(self, name, content):
        path = self.folder / name
        path.write_bytes(content)
        return path

    def refuse_each(self, *jobs, ranks=2):
        """Runs that end with one message: each is a list of arguments, and parts of the message."""
        for (arguments, *says), result in zip(jobs, run_each((ranks, *job[0]) for job in jobs)):
            self.assertEqual(result.returncode, 1, f"{arguments}: {result.stderr}")
            self.assertEqual(result.stdout.count("triangles,"), 0)
            self.assertNotIn("mca_", result.stderr)
            self.assertEqual(len(messages(result.stderr)), 1, f"{arguments}: {result.stderr}")
            for part in says:
                self.assertIn(part, messages(result.stderr)[0])

    def proxima(self, *arguments):
        result = subprocess.run([PROXIMA, *map(str, arguments)], capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def rank_rows(self, text, ranks):
        """What the table of an octree's ranks says of each."""
        lines = text.splitlines()
        first = next(i for i, line in enumerate(lines) if line.startswith("Rank"))
        names = [name.strip() for name in lines[first].split("  ") if name.strip()]
        rows = [dict(zip(names, map(int, line.split()))) for line in lines[first + 2:first + 2 + ranks]]
        self.assertEqual([row["Rank"] for row in rows], list(range(ranks)))
        return rows

    @staticmethod
    def figures(text):
        """The two tables of an octree, without what differs from run to run."""
        lines = [line.split() for line in text.splitlines()]
        first = next(i for i, line in enumerate(lines) if line[:2] == ["Depth", "Threshold"])
        return lines[first:first + 7]
