"""A model of what proxima-mpi octree costs a rank: fitted, checked on other measurements, and carried on to larger meshes.

Work is a rank's processor time without messages and waiting. It is modelled as

    start + a slice + b received + c cells + d pairs + e leaves + f sent

    slice      triangles of the whole / ranks: what a rank sorts into cells and packs
    received   triangles that touch its cells
    cells      at the routing depth or above, each of which is grown by itself
    pairs      of a triangle and a cell that was split, over all levels below the routing depth
    leaves     of its cells: what is classified
    sent       bytes that it packed for other ranks

All of these but the share are counts that the program prints. The coefficients come from nonnegative least squares of relative errors over
half of the runs, drawn at random with a fixed seed. The work of each rank is the least of all rounds, for what else the machine does only adds.
"""
import os
import random
import re
import statistics
import subprocess
from dataclasses import dataclass
from itertools import product

import numpy

MESHES = ["torus:200x150", "torus:400x300", "torus:500x450", "torus:700x600"]
DEPTHS = [7, 8, 9]
RANKS = [1, 2, 3, 4, 6]
THRESHOLD = 8
ROUTING_DEPTH = 5
SEED = 24
TERMS = ["start", "slice", "received", "cells", "pairs", "leaves", "sent"]
COLUMNS = ["Rank", "Cells", "Triangles", "Leaves", "Pairs split", "Pointers", "Work us", "Messages", "Bytes sent", "Peak MB"]


def ranks_command(program, ranks, arguments):
    root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
    # Not bound: by default, mpirun binds one or two ranks to the first cores, so that two runs at once would share a core.
    # Containers forbid the copies between processes that Open MPI would make by a system call.
    return ["mpirun", *root, "--oversubscribe", "--bind-to", "none", "-n", str(ranks),
            "--mca", "btl_vader_single_copy_mechanism", "none", program, "octree", *arguments]


def rank_rows(output):
    """What the table of ranks says, by its headings."""
    table = output[output.index("Rank  "):]
    return [dict(zip(COLUMNS, map(int, row.split()))) for row in re.findall(rf"^ *\d+(?: +\d+){{{len(COLUMNS) - 1}}}$", table, re.M)]


def triangles_of(mesh):
    around, across = map(int, mesh.removeprefix("torus:").split("x"))
    return 2 * around * across


@dataclass
class Run:
    mesh: str
    depth: int
    ranks: int
    rows: list  # by rank

    @property
    def triangles(self):
        return triangles_of(self.mesh)

    @property
    def terms(self):
        """By rank."""
        share = self.triangles / self.ranks
        columns = ["Triangles", "Cells", "Pairs split", "Leaves", "Bytes sent"]
        return numpy.array([[1.0, share, *(row[column] for column in columns)] for row in self.rows])

    @property
    def work(self):
        return numpy.array([row["Work us"] for row in self.rows])

    def sum_of(self, column):
        return sum(row[column] for row in self.rows)


def nonnegative_least_squares(matrix, wanted):
    """The best of all sets of terms whose coefficients are positive: there are few terms."""
    best, least = None, numpy.inf
    count = matrix.shape[1]
    for used in product([False, True], repeat=count):
        if not any(used):
            continue
        part, *_ = numpy.linalg.lstsq(matrix[:, used], wanted, rcond=None)
        error = numpy.sum((matrix[:, used] @ part - wanted) ** 2)
        if part.min() >= 0 and error < least:
            best, least = numpy.zeros(count), error
            best[list(used)] = part
    return best


def measure(program, rounds):
    """All runs in each round, in an order of its own, so that a busy minute does not meet all rounds of one run."""
    runs = [Run(*shape, []) for shape in product(MESHES, DEPTHS, RANKS)]
    for number in range(rounds):
        for run in random.Random(number).sample(runs, len(runs)):
            arguments = [run.mesh, "--depth", str(run.depth), "--threshold", str(THRESHOLD), "--routing-depth", str(ROUTING_DEPTH)]
            result = subprocess.run(ranks_command(program, run.ranks, arguments), capture_output=True, text=True)
            if result.returncode != 0:
                raise SystemExit(f"{run.ranks} ranks on {' '.join(arguments)} failed: {result.stderr}")
            rows = rank_rows(result.stdout)
            for row, before in zip(rows, run.rows):
                row["Work us"] = min(row["Work us"], before["Work us"])
            run.rows = rows
    return runs


def fit(runs):
    terms = numpy.concatenate([run.terms for run in runs])
    work = numpy.concatenate([run.work for run in runs])
    scale = terms.max(axis=0)
    scale[scale == 0] = 1
    return nonnegative_least_squares(terms / scale / work[:, None], numpy.ones(len(work))) / scale


def describe_errors(name, coefficients, runs):
    """Relative errors of the busiest ranks' work."""
    errors = {f"{run.mesh} at depth {run.depth} on {run.ranks} rank{'s' * (run.ranks > 1)}": (run.terms @ coefficients).max() / run.work.max() - 1 for run in runs}
    sizes = numpy.abs(list(errors.values()))
    print(f"{name}: {len(runs)} runs, mean {100 * sizes.mean():.1f} %, 90 of 100 below {100 * numpy.quantile(sizes, 0.9):.1f} %, "
          f"worst {100 * sizes.max():.1f} %, {numpy.sum(sizes <= 0.15)} runs within 15 %")
    for run, error in errors.items():
        if abs(error) > 0.15:
            print(f"  {run}: {100 * error:+.1f} %")


@dataclass
class Growth:
    """Of a surface, by triangle of a rank's share, but for its cells; copies by the square root of the share."""
    cells: float  # of the whole mesh
    pairs: float  # at the deepest level of the largest mesh, whose cells are about as small as the threshold allows
    level: float  # pairs that each further level adds above: of triangles that are small beside its cells
    leaves: float
    copies: float
    sent: float  # bytes, as if 1 / ranks of the triangles were at home
    memory: float  # bytes


def growth(runs):
    of_largest = [run for run in runs if run.mesh == MESHES[-1]]
    deepest = [run for run in of_largest if run.depth == max(DEPTHS)]
    shallowest = [run for run in of_largest if run.depth == min(DEPTHS)]
    split = [run for run in runs if run.ranks > 1]
    large, small = (max(run.rows[0]["Peak MB"] for run in runs if run.mesh == mesh and run.ranks == 1) for mesh in (MESHES[-1], MESHES[0]))
    levels = min(DEPTHS) - ROUTING_DEPTH
    return Growth(cells=deepest[0].sum_of("Cells"),
                  pairs=statistics.median(run.sum_of("Pairs split") / run.triangles for run in deepest),
                  level=statistics.median(run.sum_of("Pairs split") / run.triangles / levels for run in shallowest),
                  leaves=statistics.median(run.sum_of("Leaves") / run.triangles for run in deepest),
                  copies=max((run.terms[:, 2] - run.terms[:, 1]).max() / (run.triangles / run.ranks) ** 0.5 for run in split),
                  sent=max(run.sum_of("Bytes sent") / run.triangles * run.ranks / (run.ranks - 1) for run in split),
                  memory=1e6 * (large - small) / (triangles_of(MESHES[-1]) - triangles_of(MESHES[0])))


def extrapolate(coefficients, runs, ranks=10_000):
    grows = growth(runs)
    finest = max(run.triangles for run in runs)
    print(f"\nGrowth: {grows.pairs:.2f} pairs a triangle and {grows.level:.2f} for each further level, {grows.leaves:.2f} leaves, copies "
          f"{grows.copies:.1f} times the square root of a rank's share, {grows.sent:.0f} bytes sent and {grows.memory:.0f} bytes of memory a triangle.\n")
    print("| Triangles | of a rank | Depth | Work of a rank | Memory of a rank | Sent by a rank | Root counts, MB |")
    print("|---|---|---|---|---|---|---|")
    for whole in (1e9, 1e10, 1e11):
        share = whole / ranks
        further = numpy.log(whole / finest) / numpy.log(4)  # a level more for four times the triangles of a surface
        received = share + grows.copies * share ** 0.5
        work = coefficients @ [1.0, share, received, grows.cells / ranks, (grows.pairs + grows.level * further) * received, grows.leaves * received,
                               grows.sent * share]
        # Cells at the routing depth, 16 bytes each, that every rank tells for every depth.
        told = 16 * min(received, 8 ** ROUTING_DEPTH) / 1e6
        print(f"| {whole:.0e} | {share:.0e} | {max(DEPTHS) + further:.1f} | {work / 1e6:.2f} s "
              f"| {grows.memory * received / 1e6:.0f} MB | {grows.sent * share / 1e6:.0f} MB | {told:.2f} |")


def report(program, rounds):
    runs = measure(program, rounds)
    drawn = set(random.Random(SEED).sample(range(len(runs)), len(runs) // 2))
    fitted = [run for number, run in enumerate(runs) if number in drawn]
    checked = [run for number, run in enumerate(runs) if number not in drawn]
    coefficients = fit(fitted)
    print(f"Threshold {THRESHOLD}, routing depth {ROUTING_DEPTH}, depths {DEPTHS}, ranks {RANKS}, meshes {', '.join(MESHES)}; "
          f"least of {rounds} rounds; {len(runs)} runs, half of them drawn with seed {SEED}.\n")
    print("| " + " | ".join(TERMS) + " |\n|" + "---|" * len(TERMS))
    print("| " + " | ".join(f"{1000 * value:.1f} ns" for value in coefficients) + " |\n")
    describe_errors("fitted", coefficients, fitted)
    describe_errors("checked", coefficients, checked)
    extrapolate(coefficients, runs)
