#!/usr/bin/env python3
"""Measures proxima-mpi beside proxima on this machine, and prints a table of medians in Markdown.

    distributed_bench.py PROXIMA PROXIMA_MPI [--mesh NAME]... [--depth N] [--threshold N] [--rounds N]

Seconds are of building with classes, without reading. A round runs, one after the other: one process on one thread; one rank;
two ranks; two runs of one rank at once, which share the machine as two ranks do. So the last pair says how much faster two ranks
could be on this machine at best. Memory is the peak of a rank, its program and MPI included.
"""
import argparse
import os
import re
import statistics
import subprocess
from dataclasses import dataclass


@dataclass
class Run:
    seconds: float
    peak_megabytes: int  # of the rank that needs most
    sent_bytes: int = 0  # by all ranks


def ranks_command(program, ranks, arguments):
    root = ["--allow-run-as-root"] if os.geteuid() == 0 else []
    # Containers forbid the copies between processes that Open MPI would make by a system call.
    return ["mpirun", *root, "--oversubscribe", "-n", str(ranks), "--mca", "btl_vader_single_copy_mechanism", "none", program, "octree", *arguments]


def ranks_run(output):
    rows = re.findall(r"^ *\d+ +\d+ +\d+ +\d+ +(\d+) +(\d+)$", output, re.M)
    return Run(float(re.search(r"built in ([\d.]+) s", output)[1]), max(int(peak) for _, peak in rows), sum(int(sent) for sent, _ in rows))


def at_once(commands):
    processes = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for command in commands]
    outputs = [process.communicate()[0] for process in processes]
    if any(process.returncode for process in processes):
        raise SystemExit(f"failed: {' '.join(commands[0])}")
    return outputs


def measure(options, mesh):
    arguments = [mesh, "--depth", str(options.depth), "--threshold", str(options.threshold)]
    runs = {"process": [], 1: [], 2: [], "pair": []}
    for _ in range(options.rounds):
        text = at_once([[options.proxima, "octree", *arguments, "--threads", "1"]])[0]
        runs["process"].append(Run(float(re.search(r", ([\d.]+) s$", text.splitlines()[0])[1]), 0))
        for ranks in (1, 2):
            runs[ranks].append(ranks_run(at_once([ranks_command(options.proxima_mpi, ranks, arguments)])[0]))
        pair = [ranks_run(text) for text in at_once([ranks_command(options.proxima_mpi, 1, arguments)] * 2)]
        runs["pair"].append(Run(statistics.mean(run.seconds for run in pair), 0))
    seconds = {name: statistics.median(run.seconds for run in some) for name, some in runs.items()}
    peak = {ranks: max(run.peak_megabytes for run in runs[ranks]) for ranks in (1, 2)}
    return (f"| {os.path.basename(mesh)} | {seconds['process']:.3f} s | {seconds[1]:.3f} s | {seconds[1] / seconds['process']:.2f} "
            f"| {seconds[2]:.3f} s | {seconds[1] / seconds[2]:.2f} | {2 * seconds[1] / seconds['pair']:.2f} "
            f"| {peak[1]} MB | {peak[2]} MB | {max(run.sent_bytes for run in runs[2]) / 1e6:.1f} MB |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proxima")
    parser.add_argument("proxima_mpi")
    parser.add_argument("--mesh", action="append")
    parser.add_argument("--depth", type=int, default=9)
    parser.add_argument("--threshold", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    print(f"Depth {options.depth}, threshold {options.threshold}, medians of {options.rounds} rounds.\n")
    print("| Mesh | One process | One rank | to one process | Two ranks | Faster than one | at best here | Peak, one rank | Peak, two | Sent by two |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for mesh in options.mesh or ["torus:660x660"]:
        print(measure(options, mesh), flush=True)


if __name__ == "__main__":
    main()
