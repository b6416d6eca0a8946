#!/usr/bin/env python3
"""Prints medians of a Google Benchmark report, wall and processor time, and within each group "name/" the
ratio to `fast`, or to the row registered first where there is none. Rows with "threads" in their name compare wall time
with wall time, the others processor time with processor time. Exit status 1 where a benchmark failed.

    bench/summary.py REPORT.json
"""
import json
import statistics
import sys


def main(path):
    with open(path) as file:
        report = json.load(file)
    context = report["context"]
    print(f"{context['num_cpus']} cores at {context['mhz_per_cpu']} MHz, load {context['load_avg']}, "
          "medians of interleaved repetitions")
    groups = {}
    errors = {}
    for run in report["benchmarks"]:
        if run.get("error_occurred"):
            errors[run["run_name"]] = run.get("error_message", "an error")
        if run.get("run_type") != "iteration" or run.get("error_occurred"):
            continue
        group, _, method = run["run_name"].removesuffix("/real_time").removesuffix("/manual_time").partition("/")
        groups.setdefault(group, {}).setdefault(method, []).append(run)
    for group, methods in groups.items():
        print(f"\n{group}")
        wall, cpu = ({method: statistics.median(run[clock] for run in runs)
                      for method, runs in methods.items()} for clock in ("real_time", "cpu_time"))
        base = "fast" if "fast" in methods else min(methods, key=lambda method: methods[method][0]["family_index"])
        print(f"  {'':24s} {'wall':>10s}    {'cpu':>10s}    {'ratio':>10s}")
        for method, runs in sorted(methods.items(), key=lambda item: wall[item[0]]):
            clock = wall if "threads" in method else cpu
            time = clock[method]
            unit = runs[0]["time_unit"]
            notes = ["by wall time"] if clock is wall else []
            if "references" in runs[0]:
                notes.append(f"{1e6 * time / runs[0]['references']:.1f} ns/reference")
                notes.append(f"{runs[0]['bytes'] / runs[0]['triangles']:.1f} bytes/triangle")
                notes.append(f"peak {max(run['peak_over_octree'] for run in runs):.2f} x octree")
            if "facets" in runs[0]:
                nanoseconds = {"ns": 1, "us": 1e3, "ms": 1e6}[unit]
                notes.append(f"{nanoseconds * time / runs[0]['facets']:.0f} ns/facet")
            if "seconds_per_pair" in runs[0]:
                per_pair = statistics.median(run["seconds_per_pair"] for run in runs)
                notes.append(f"{1e9 * per_pair:.0f} ns/(triangle, cell)")
            if "hash" in runs[0]:
                hashes = sorted({f"{round(run['hash']):x}" for run in runs})
                notes.append(f"{runs[0]['vertices']:.0f} vertices, {runs[0]['triangles']:.0f} triangles, hash "
                             + " or ".join(hashes))
            if runs[0].get("label"):
                notes.append(runs[0]["label"])
            print(f"  {method:24s} {wall[method]:10.3f} {unit} {cpu[method]:10.3f} {unit} "
                  f"{time / clock[base]:8.2f} x  {', '.join(notes)}")
    for name, what in errors.items():
        print(f"summary.py: {name} failed: {what}", file=sys.stderr)
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
