"""The installed program: loaded at a random place, its tables of functions read-only before main, no stack that can
be executed."""
import subprocess
import sys


def readelf(option):
    return subprocess.run(["readelf", "-W", option, sys.argv[1]], capture_output=True, text=True, check=True).stdout


dynamic, header, segments = readelf("-d"), readelf("-h"), readelf("-l")
stack = [line.split() for line in segments.splitlines() if "GNU_STACK" in line]
checks = {
    "position-independent (-pie)": "DYN" in header and "PIE" in dynamic,
    "bound before main (-z now)": "BIND_NOW" in dynamic or "NOW" in dynamic,
    "read-only relocations (-z relro)": "GNU_RELRO" in segments,
    "no executable stack": bool(stack) and all("E" not in line[-2] for line in stack),
}
missing = [name for name, holds in checks.items() if not holds]
if missing:
    sys.exit(f"{sys.argv[1]} is not " + ", ".join(missing))
print("hardened:", ", ".join(checks))
