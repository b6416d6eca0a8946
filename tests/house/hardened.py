"""The programs, shared libraries and modules that users get: loaded at a random place, their tables of functions read-only before main,
no stack that can be executed, and code that notices an overwritten stack and copies that do not fit."""
import json
import re
import subprocess
import sys
from pathlib import Path


def readelf(option, file):
    return subprocess.run(["readelf", "-W", option, file], capture_output=True, text=True, check=True).stdout


def compiled_with(option, target, build):
    """Whether there are sources of the target's own, and all are compiled with such an option."""
    commands = [one["command"].split() for one in json.loads((build / "compile_commands.json").read_text())]
    own = [words for words in commands if any(f"/{target}.dir/" in word for word in words)]
    return bool(own) and all(any(re.fullmatch(option, word) for word in words) for words in own)


for target, file in (word.split("=", 1) for word in sys.argv[2:]):
    dynamic, header, segments, symbols = (readelf(option, file) for option in ("-d", "-h", "-l", "--dyn-syms"))
    stack = [line.split() for line in segments.splitlines() if "GNU_STACK" in line]
    checks = {
        "position-independent (-pie or -shared)": "DYN" in header and ("PIE" in dynamic or "INTERP" not in segments),
        "bound before main (-z now)": "BIND_NOW" in dynamic or "NOW" in dynamic,
        "read-only relocations (-z relro)": "GNU_RELRO" in segments,
        "no executable stack": bool(stack) and all("E" not in line[-2] for line in stack),
        "stack protector (-fstack-protector-strong)": "__stack_chk_fail" in symbols,
        # A small library may copy nothing whose size the compiler knows.
        "checked copies (_FORTIFY_SOURCE)": re.search(r"\b__\w+_chk\b", symbols) is not None or
                                            compiled_with("-D_FORTIFY_SOURCE=[23]", target, Path(sys.argv[1])),
    }
    missing = [name for name, holds in checks.items() if not holds]
    if missing:
        sys.exit(f"{file} is not " + ", ".join(missing))
    print(f"{file} is hardened:", ", ".join(checks))
