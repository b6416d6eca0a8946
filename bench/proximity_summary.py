#!/usr/bin/env python3
"""Prints the tables of a report by proximity_bench: per mesh the medians of all rounds, ratios to Embree in the
same run, agreement, and tails. A report made with --curve is printed as CSV instead, one line per mesh and budget.

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


def print_means(methods, triangles):
    singles = {m["name"]: [median(m["sets"][s]["single"]) for s in SETS] for m in methods}
    batches = {m["name"]: [median(m["sets"][s]["batch"]) for s in SETS] for m in methods}
    base = singles.get("embree")
    ratios = base is not None

    def times_faster(times):
        return [b / t if ratios and t is not None else None for b, t in zip(base or times, times)]

    heads = [f"single {s}" for s in SETS] + [f"batch {s}" for s in SETS]
    print("\nNanoseconds per query" + (", and how many times as fast as Embree's single queries" if ratios else ""))
    print(f"  {'':14s}{'bytes/tri':>10s}{'build s':>9s}" + "".join(h.rjust(10) for h in heads))
    for m in methods:
        times = singles[m["name"]] + batches[m["name"]]
        print(f"  {m['name']:14s}{m['bytes'] / triangles:10.0f}{m['build_seconds']:9.2f}" + cells(times, 10))
        if ratios:
            factors = times_faster(singles[m["name"]]) + times_faster(batches[m["name"]])
            print(f"  {'':33s}" + cells(factors, 10, "{:.2f} x"))


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
