#!/usr/bin/env python3
"""Where the time of the test suite goes: seconds by group, and the longest tests. Tables of Markdown.

    scripts/test_times.py [build/dev/tests.xml] [COUNT]    what scripts/test wrote; the longest COUNT tests, ten by default

A test's seconds are from its start to its end, while others ran beside it.
"""
import collections
import pathlib
import sys
import xml.etree.ElementTree as xml

DEFAULT = pathlib.Path(__file__).resolve().parent.parent / "build/dev/tests.xml"


def main(path=DEFAULT, count=10):
    if not pathlib.Path(path).is_file():
        sys.exit(f"test_times: {path}: there is no such file; scripts/test writes one")
    suite = xml.parse(path).getroot()
    seconds = {test.get("name"): float(test.get("time") or 0) for test in suite.iter("testcase") if test.get("status") in ("run", "fail")}
    groups = collections.defaultdict(list)
    for name, time in seconds.items():
        groups[name.split(".")[0]].append(time)
    print("| Group | Tests | Seconds |\n|---|---:|---:|")
    for group, times in sorted(groups.items(), key=lambda one: -sum(one[1])):
        print(f"| {group} | {len(times)} | {sum(times):.0f} |")
    print(f"| all, one after the other | {len(seconds)} | {sum(seconds.values()):.0f} |")
    print("\n| Test | Seconds |\n|---|---:|")
    for name in sorted(seconds, key=lambda one: -seconds[one])[:int(count)]:
        print(f"| `{name}` | {seconds[name]:.1f} |")


if __name__ == "__main__":
    main(*sys.argv[1:])
