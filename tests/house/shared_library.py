#!/usr/bin/env python3
"""What libproxima.so shows to the outside: it exports what the public headers declare and nothing else, has a name that
programs remember, and wants no library but those that queries on arrays need.

    shared_library.py LIBRARY SONAME INCLUDE_FOLDER     exit status 1 where that is not so
"""
import re
import subprocess
import sys
from pathlib import Path

# assimp reads scenes: it is opened when the first one is read.
NEEDED = {"libtbb.so", "libhwy.so", "libxxhash.so", "libstdc++.so", "libm.so", "libgcc_s.so", "libc.so", "ld-linux-x86-64.so",
          "ld-linux-aarch64.so"}
PREFIXES = ("typeinfo for ", "typeinfo name for ", "vtable for ")


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def exported(library):
    """Names of the exported symbols as in C++."""
    return [line.split(" ", 2)[2] for line in output("nm", "-D", "--defined-only", "-C", library).splitlines()]


def declared(folder):
    """The public headers' functions and variables, and the classes that they define."""
    text = "\n".join(path.read_text() for path in folder.glob("*.h"))
    text = re.sub(r"//.*", "", text)
    classes = set(re.findall(r"\b(?:class|struct)\s+(\w+)(?:\s+final)?\s*(?::[^;{]*)?\{", text))
    return set(re.findall(r"\b\w+\b", text)), classes


def problem(symbol, words, classes):
    """Why the symbol is none of the public headers; None where it is."""
    for prefix in PREFIXES:
        symbol = symbol.removeprefix(prefix)
    name = re.sub(r"\(.*|\[abi:.*", "", symbol, flags=re.DOTALL)
    if not re.fullmatch(r"proxima::(\w+|~\w+|operator\W+)(::(\w+|~\w+|operator\W*))*", name):
        return "is not a plain name of the namespace"
    parts = [part.removeprefix("~") for part in name.split("::")[1:]]
    unknown = [part for part in parts if part.isidentifier() and part not in words]
    unknown += [part for part in parts[:-1] if part not in classes]
    unknown += [word for word in re.findall(r"proxima::(\w+)", symbol) if word not in words]
    return f"has {unknown[0]}, which no public header has" if unknown else None


def main():
    library, soname, folder = sys.argv[1], sys.argv[2], Path(sys.argv[3])
    words, classes = declared(folder)
    symbols = exported(library)
    problems = [f"{symbol} is exported and {reason}" for symbol in symbols
                if (reason := problem(symbol, words, classes)) is not None]
    for name in ("proxima::closest_feature(", "proxima::build_mesh_index(", "typeinfo for proxima::Device"):
        if not any(symbol.startswith(name) for symbol in symbols):
            problems.append(f"{name.rstrip('(')} is not exported")
    dynamic = output("readelf", "-W", "-d", library)
    if f"Library soname: [{soname}]" not in dynamic:
        problems.append(f"its name is not {soname}:\n{dynamic}")
    for needed in re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic):
        if needed.split(".so")[0] + ".so" not in NEEDED:
            problems.append(f"it needs {needed}")
    print(f"{len(symbols)} symbols are exported")
    for line in problems:
        print(line)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
