#!/usr/bin/env python3
"""Prints the tables of a report by proximity_bench: per mesh the medians of all rounds, ratios to the fastest of
Embree in the same run, agreement, and tails. A report made with --curve is printed as CSV instead, one line per mesh and budget.

    bench/proximity_summary.py REPORT.json
"""
import json
import statistics
import sys

SETS = {"a": "in the box scaled 1.2 times", "b": "within 1 % of the surface", "c": "coherent walk near the surface"}


def median(times):
    return statistics.median(times) if times else None


def cells(values, width=9, form="{:.0f}"):
    return "".join((form.format(v) if v is not None else "-").rjust(width) for v in values)


def load_text(mesh):
    before, after = (", ".join(f"{x:.1f}" for x in mesh[key]) for key in ("load_before", "load_after"))
    return f"load {before} before and {after} after"


def fastest_of_embree(times):
    """Of each column the name and time of the faster one of Embree's peers; None where there is none."""
    peers = [name for name in ("embree", "embree-warm") if name in times]

    def fastest(column):
        there = [(times[name][column], name) for name in peers if times[name][column] is not None]
        return min(there, default=None)

    return [fastest(column) for column in range(2 * len(SETS))]


def print_means(methods, triangles):
    times = {m["name"]: [median(m["sets"][s][kind]) for kind in ("single", "batch") for s in SETS] for m in methods}
    bases = fastest_of_embree(times)
    heads = [f"{kind} {s}" for kind in ("single", "batch") for s in SETS]
    ratios = any(bases)
    print("\nNanoseconds per query" + (", and how many times as fast as the faster peer of Embree in that column" if ratios else ""))
    print(f"  {'':14s}{'bytes/tri':>10s}{'build s':>9s}{'of':>4s}" + "".join(h.rjust(12) for h in heads))
    for m in methods:
        print(f"  {m['name']:14s}{m['bytes'] / triangles:10.0f}{m['build_seconds']:9.3f}{m['builds']:4d}" + cells(times[m["name"]], 12))
        if ratios:
            factors = [base[0] / time if base and time is not None else None for base, time in zip(bases, times[m["name"]])]
            print(f"  {'':37s}" + cells(factors, 12, "{:.2f} x"))
    if ratios:
        print(f"  {'ratios are to':37s}" + "".join((base[1] if base else "-").rjust(12) for base in bases))
    print("  build s: the median of so many builds in turn, processor time")
    for m in methods:
        if "byte_parts" in m:
            parts = " + ".join(f"{name} {size / triangles:.0f}" for name, size in m["byte_parts"].items())
            print(f"  bytes/tri of {m['name']}: {parts}")


def print_agreement(methods):
    print("\nAgreement: queries, the most that a distance is off over the diagonal, how many are off by over 1e-12, hash")
    for m in methods:
        for name, result in m["sets"].items():
            print(f"  {m['name']:14s}{name}  {result['queries']:9d}  {result['deviation']:8.1e}  "
                  f"{result['wrong']:6d}  {result['hash']}")


def print_tails(methods):
    print("\nTails in nanoseconds, the least of five runs of every query: p50, p99, p99.99, max, p99.99 over p50")
    for m in methods:
        for name, result in m["sets"].items():
            ranks = [result[rank] for rank in ("p50", "p99", "p99.99", "max")]
            print(f"  {m['name']:14s}{name}{cells(ranks, 11)}{ranks[2] / max(ranks[0], 1):9.1f} x")


def print_curve(report):
    """Speed against budget; the columns are single and batch medians in nanoseconds."""
    columns = [f"{kind}_{s}" for kind in ("single", "batch") for s in SETS]
    print(",".join(["mesh", "triangles", "budget_bytes_per_triangle", "bytes_per_triangle", "build_seconds", *columns]))
    for mesh in report["meshes"]:
        for row in mesh.get("curve", []):
            times = [median(row["sets"][s][kind]) for kind in ("single", "batch") for s in SETS]
            print(",".join([mesh["name"], str(mesh["triangles"]), f"{row['budget']:g}",
                            f"{row['bytes'] / mesh['triangles']:.1f}", f"{row['build_seconds']:.3f}",
                            *("" if t is None else f"{t:.1f}" for t in times)]))


def print_tables(report):
    print(f"{report['processor']}, one thread; {report['queries']} queries a set from seed {report['seed']}, "
          f"medians of {report['rounds']} interleaved rounds")
    for name, what in SETS.items():
        print(f"  {name}: {what}")
    for mesh in report["meshes"]:
        print(f"\n{mesh['name']}: {mesh['triangles']} triangles, {load_text(mesh)}")
        print_means(mesh["methods"], mesh["triangles"])
        print_agreement(mesh["methods"])
        print_tails(mesh["methods"])


def main(path):
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    if any("curve" in mesh for mesh in report.get("meshes", [])):
        print_curve(report)
    else:
        print_tables(report)


if __name__ == "__main__":
    main(sys.argv[1])
