"""The programs, shared libraries and modules that users get: loaded at a random place, their tables of functions read-only before main,
no stack that can be executed, and code that notices an overwritten stack and copies that do not fit."""
import re
import subprocess
import sys


def readelf(option, file):
    return subprocess.run(["readelf", "-W", option, file], capture_output=True, text=True, check=True).stdout


for file in sys.argv[1:]:
    dynamic, header, segments, symbols = (readelf(option, file) for option in ("-d", "-h", "-l", "--dyn-syms"))
    stack = [line.split() for line in segments.splitlines() if "GNU_STACK" in line]
    checks = {
        "position-independent (-pie or -shared)": "DYN" in header and ("PIE" in dynamic or "INTERP" not in segments),
        "bound before main (-z now)": "BIND_NOW" in dynamic or "NOW" in dynamic,
        "read-only relocations (-z relro)": "GNU_RELRO" in segments,
        "no executable stack": bool(stack) and all("E" not in line[-2] for line in stack),
        "stack protector (-fstack-protector-strong)": "__stack_chk_fail" in symbols,
        "checked copies (_FORTIFY_SOURCE)": re.search(r"\b__\w+_chk\b", symbols) is not None,
    }
    missing = [name for name, holds in checks.items() if not holds]
    if missing:
        sys.exit(f"{file} is not " + ", ".join(missing))
    print(f"{file} is hardened:", ", ".join(checks))
