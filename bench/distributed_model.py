"""A model of what proxima-mpi octree costs a rank: fitted, checked on other measurements, and carried on to larger meshes.

Work is a rank's processor time without messages and waiting. It is modelled as

    start + a slice + b received + c pointers levels + d copies + e messages

    slice      triangles of the whole / ranks: what a rank reads and sorts into cells
    received   triangles that touch its cells
    pointers   references of its leaves, each of which came down through `levels` below the routing depth
    copies     triangles received by the rank beyond its share: those at its boundary
    messages   non-empty ones that it sent

The coefficients come from nonnegative least squares of relative errors over half of the runs: every second one in the order in which
the runs are listed. Each run is the median of its rounds; ranks of a run are samples of their own.
"""
import os
import re
import statistics
import subprocess
from itertools import product

import numpy

MESHES = ["torus:200x150", "torus:400x300", "torus:500x450", "torus:700x600"]
DEPTHS = [7, 8, 9]
RANKS = [1, 2, 3, 4, 6]
THRESHOLD = 8
ROUTING_DEPTH = 5
TERMS = ["start", "slice", "received", "pointers x levels", "copies", "messages"]


def ranks_command(program, ranks, arguments):
    root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
    # Containers forbid the copies between processes that Open MPI would make by a system call.
    return ["mpirun", *root, "--oversubscribe", "-n", str(ranks), "--mca", "btl_vader_single_copy_mechanism", "none", program, "octree", *arguments]


def rank_rows(output):
    """What the table of ranks says, by its headings."""
    names = ["Rank", "Cells", "Triangles", "Pointers", "Work us", "Messages", "Bytes sent", "Peak MB"]
    table = output[output.index("Rank"):]
    return [dict(zip(names, map(int, row.split()))) for row in re.findall(r"^ *\d+(?: +\d+){7}$", table, re.M)]


def median_ranks(program, mesh, depth, ranks, rounds):
    """The rows of a run; work is the median of the rounds."""
    arguments = [mesh, "--depth", str(depth), "--threshold", str(THRESHOLD), "--routing-depth", str(ROUTING_DEPTH)]
    runs = [rank_rows(subprocess.run(ranks_command(program, ranks, arguments), check=True, capture_output=True, text=True).stdout)
            for _ in range(rounds)]
    return [{**of_rank[0], "Work us": statistics.median(row["Work us"] for row in of_rank)} for of_rank in zip(*runs)]


def triangles_of(mesh):
    across, around = map(int, mesh.removeprefix("torus:").split("x"))
    return 2 * across * around


def terms_of(whole, ranks, received, pointers, levels, messages):
    share = whole / ranks
    return [1.0, share, received, pointers * levels, max(received - share, 0), messages]


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
    """Terms and microseconds of every rank of every run, run by run."""
    runs = []
    for mesh, depth, ranks in product(MESHES, DEPTHS, RANKS):
        rows = median_ranks(program, mesh, depth, ranks, rounds)
        whole = triangles_of(mesh)
        terms = [terms_of(whole, ranks, row["Triangles"], row["Pointers"], depth - ROUTING_DEPTH, row["Messages"]) for row in rows]
        runs.append((mesh, depth, ranks, rows, numpy.array(terms), numpy.array([row["Work us"] for row in rows])))
    return runs


def fit(runs):
    terms = numpy.concatenate([run[4] for run in runs])
    work = numpy.concatenate([run[5] for run in runs])
    scale = numpy.abs(terms).max(axis=0)
    scale[scale == 0] = 1
    return nonnegative_least_squares(terms / scale / work[:, None], numpy.ones(len(work))) / scale


def errors_of(coefficients, runs):
    """Relative errors of the busiest ranks' work, by run."""
    return numpy.array([(run[4] @ coefficients).max() / run[5].max() - 1 for run in runs])


def describe_errors(name, errors):
    sizes = numpy.abs(errors)
    print(f"{name}: {len(errors)} runs, mean {100 * sizes.mean():.1f} %, 90 of 100 below {100 * numpy.quantile(sizes, 0.9):.1f} %, "
          f"worst {100 * sizes.max():.1f} %, {100 * numpy.mean(sizes <= 0.15):.0f} % of runs within 15 %")


def growth(runs):
    """Of a surface: pointers of a triangle once cells are as small as the threshold allows, copies of a rank by the square root of its
    share, bytes sent and peak bytes by triangle."""
    deepest = [run for run in runs if run[1] == max(DEPTHS)]
    pointers = statistics.median(sum(row["Pointers"] for row in run[3]) / triangles_of(run[0]) for run in deepest)
    copies = max(run[4][:, 4].max() / (triangles_of(run[0]) / run[2]) ** 0.5 for run in runs if run[2] > 1)
    sent = statistics.median(sum(row["Bytes sent"] for row in run[3]) / triangles_of(run[0]) for run in runs if run[2] > 1)
    large, small = (max(run[3][0]["Peak MB"] for run in runs if run[0] == mesh and run[2] == 1) for mesh in (MESHES[-1], MESHES[0]))
    peak = 1e6 * (large - small) / (triangles_of(MESHES[-1]) - triangles_of(MESHES[0]))
    return pointers, copies, sent, peak


def extrapolate(coefficients, runs, ranks=10_000):
    pointers, copies, sent, peak = growth(runs)
    print(f"\nGrowth: {pointers:.2f} pointers a triangle, copies {copies:.1f} times the square root of a rank's share, "
          f"{sent:.0f} bytes sent and {peak:.0f} bytes of memory a triangle.\n")
    print("| Triangles | of a rank | Depth | Work of a rank | Memory of a rank | Sent by a rank | Root counts, MB |")
    print("|---|---|---|---|---|---|---|")
    for whole in (1e9, 1e10, 1e11):
        share = whole / ranks
        # A level more for four times the triangles of a surface.
        depth = max(DEPTHS) + numpy.log(whole / triangles_of(MESHES[-1])) / numpy.log(4)
        received = share + copies * share ** 0.5
        messages = 3 * (ranks - 1)  # all ranks may get something, in three exchanges
        terms = terms_of(whole, ranks, received, pointers * received, depth - ROUTING_DEPTH, messages)
        work = coefficients @ terms
        # Cells at the routing depth, 16 bytes each, that every rank tells for every depth.
        told = 16 * min(received, 8 ** ROUTING_DEPTH) / 1e6
        print(f"| {whole:.0e} | {share:.0e} | {depth:.1f} | {work / 1e6:.2f} s "
              f"| {peak * received / 1e6:.0f} MB | {sent * share / 1e6:.0f} MB | {told:.2f} |")
    return pointers


def report(program, rounds):
    runs = measure(program, rounds)
    fitted, checked = runs[0::2], runs[1::2]
    coefficients = fit(fitted)
    print(f"Threshold {THRESHOLD}, routing depth {ROUTING_DEPTH}, depths {DEPTHS}, ranks {RANKS}, meshes {', '.join(MESHES)}; "
          f"medians of {rounds} rounds; {len(runs)} runs.\n")
    print("| " + " | ".join(TERMS) + " |\n|" + "---|" * len(TERMS))
    print("| " + " | ".join(f"{1000 * value:.1f} ns" for value in coefficients) + " |\n")
    describe_errors("fitted", errors_of(coefficients, fitted))
    describe_errors("checked", errors_of(coefficients, checked))
    extrapolate(coefficients, runs)
