#!/usr/bin/env python3
"""The last lines of what failed tests printed, then the test runner's summary: for logs that keep only their end.

    scripts/failed_tests.py RESULTS.xml        as ctest --output-junit writes them
"""
import sys
import xml.etree.ElementTree as xml

LINES = 25


def has_failed(test):
    """So has one that could not be run, but not one that skipped itself."""
    skipped = test.find("skipped")
    return test.find("failure") is not None or skipped is not None and not skipped.get("message", "").startswith("SKIP_")


def main(path):
    suite = xml.parse(path).getroot()
    failed = [test for test in suite.iter("testcase") if has_failed(test)]
    for test in failed:
        lines = (test.findtext("system-out") or "").rstrip().splitlines()
        print(f"\n{test.get('name')} ended so, after {float(test.get('time') or 0):.0f} s:")
        print("\n".join(f"    {line}" for line in lines[-LINES:]))
    count = sum(test.get("status") != "disabled" for test in suite.iter("testcase"))
    print(f"\n{100 * (count - len(failed)) // max(1, count)}% tests passed, {len(failed)} tests failed out of {count}")
    print("\nThe following tests FAILED:")
    for test in failed:
        print(f"\t{test.get('name')}")


if __name__ == "__main__":
    main(sys.argv[1])
