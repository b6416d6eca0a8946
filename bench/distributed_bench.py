#!/usr/bin/env python3
"""Measures proxima-mpi beside proxima on this machine, and prints a table of medians in Markdown.

    distributed_bench.py PROXIMA PROXIMA_MPI [--mesh NAME]... [--depth N] [--threshold N] [--rounds N]
    distributed_bench.py PROXIMA PROXIMA_MPI --model [--rounds N]      fits a model of the cost (distributed_model.py)

A round runs, one after the other: one process on one thread; one rank; two ranks; two runs of one rank at once, which share the
machine as two ranks do and so tell how much faster two ranks could be here at best. All build with classes; reading does not count.
Work is the busiest rank's processor time without messages and waiting; that of one process is what it takes more than a run of
depth 0. Memory is the peak of a rank, its program and MPI included.
"""
import argparse
import os
import re
import statistics
import subprocess
from dataclasses import dataclass

import distributed_model
from distributed_model import rank_rows, ranks_command


@dataclass
class Run:
    seconds: float
    work_seconds: float
    peak_megabytes: int  # of the rank that needs most
    sent_bytes: int = 0  # by all ranks


def ranks_run(output):
    rows = rank_rows(output)
    seconds, work = re.search(r"built in ([\d.]+) s, the busiest rank's work ([\d.]+) s", output).groups()
    return Run(float(seconds), float(work), max(row["Peak MB"] for row in rows), sum(row["Bytes sent"] for row in rows))


def at_once(commands):
    """Outputs and processor times."""
    processes = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for command in commands]
    ended = []
    for process in processes:
        text = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise SystemExit(f"failed: {' '.join(process.args)}")
        ended.append((text, used.ru_utime + used.ru_stime))
    return ended


def process_run(options, mesh, shape):
    command = [options.proxima, "octree", mesh, "--threads", "1"]
    text, used = at_once([[*command, *shape]])[0]
    _, before = at_once([[*command, "--depth", "0"]])[0]
    return Run(float(re.search(r", ([\d.]+) s$", text.splitlines()[0])[1]), used - before, 0)


def measure(options, mesh):
    shape = ["--depth", str(options.depth), "--threshold", str(options.threshold)]
    runs = {"process": [], 1: [], 2: [], "pair": []}
    for _ in range(options.rounds):
        runs["process"].append(process_run(options, mesh, shape))
        command = {ranks: ranks_command(options.proxima_mpi, ranks, [mesh, *shape]) for ranks in (1, 2)}
        for ranks in (1, 2):
            runs[ranks].append(ranks_run(at_once([command[ranks]])[0][0]))
        pair = [ranks_run(text) for text, _ in at_once([command[1]] * 2)]
        runs["pair"].append(Run(statistics.mean(run.seconds for run in pair), 0, 0))
    seconds = {name: statistics.median(run.seconds for run in some) for name, some in runs.items()}
    work = {name: statistics.median(run.work_seconds for run in some) for name, some in runs.items()}
    peak = {ranks: max(run.peak_megabytes for run in runs[ranks]) for ranks in (1, 2)}
    return (f"| {os.path.basename(mesh)} | {work['process']:.2f} s | {work[1]:.2f} s | {work[1] / work['process']:.2f} "
            f"| {work[2]:.2f} s | {work[1] / work[2]:.2f} | {seconds['process']:.2f}, {seconds[1]:.2f}, {seconds[2]:.2f} s "
            f"| {seconds[1] / seconds[2]:.2f} of {2 * seconds[1] / seconds['pair']:.2f} "
            f"| {peak[1]}, {peak[2]} MB | {max(run.sent_bytes for run in runs[2]) / 1e6:.1f} MB |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proxima")
    parser.add_argument("proxima_mpi")
    parser.add_argument("--mesh", action="append")
    parser.add_argument("--depth", type=int, default=9)
    parser.add_argument("--threshold", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--model", action="store_true")
    options = parser.parse_args()
    if options.model:
        distributed_model.report(options.proxima_mpi, options.rounds)
        return
    print(f"Depth {options.depth}, threshold {options.threshold}, medians of {options.rounds} rounds.\n")
    print("| Mesh | Work of one process | of one rank | ratio | of two ranks | one rank to two | Seconds of these | One rank to two, of at best | Peak of one, of two | Sent by two |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for mesh in options.mesh or ["torus:660x660"]:
        print(measure(options, mesh), flush=True)


if __name__ == "__main__":
    main()
