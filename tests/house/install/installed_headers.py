#!/usr/bin/env python3
"""What users find after an installation: a folder of at most forty headers, which include each other, Eigen and the
standard library only; result.h also tl/expected.hpp. They compile, all together, or, as `scripts/check public_headers`
asks, each alone. Beside them one for C, which needs the C library only.

    installed_headers.py [--alone] INCLUDE_FOLDER COMPILER FLAGS...     exit status 1 where that is not so
"""
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

MOST_HEADERS = 40
FOR_C = Path("proxima/c/proxima.h")
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.MULTILINE)
# The last one: Eigen silences it, which its compiled form forgets.
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-Wno-ignored-attributes"]
STANDARD = re.compile(r"^[a-z_]+$")


def wrong_includes(folder, header):
    """Includes of a header that are none of the few that it may have."""
    for quote, name in INCLUDE.findall((folder / header).read_text()):
        ours = quote == '"' and name.startswith("proxima/") and (folder / name).is_file()
        foreign = quote == "<" and (STANDARD.match(name) or name.startswith("Eigen/"))
        expected = header.name == "result.h" and name == "tl/expected.hpp"
        if header == FOR_C:
            ours, foreign, expected = False, False, name in ("stddef.h", "stdint.h")
        if not (ours or foreign or expected):
            yield f"{header} includes {name}"


def eigen_of(folder, header):
    """The headers of Eigen that a header includes, itself or by others."""
    names = {name for _, name in INCLUDE.findall((folder / header).read_text())}
    return {name for name in names if name.startswith("Eigen/")}.union(
        *(eigen_of(folder, name) for name in names if name.startswith("proxima/") and (folder / name).is_file()))


def compile_only(headers, compiler, flags, eigen=None):
    """What the compiler says of a source that includes the headers twice and nothing else. What they include of
    Eigen may be included before them, in compiled form: most of the time would go there."""
    with tempfile.TemporaryDirectory() as work:
        source = Path(work, "only.cpp")
        source.write_text(f'#include "{eigen}"\n' * bool(eigen) + 2 * "".join(f"#include <{header}>\n" for header in headers))
        language = []
        if headers == [FOR_C]:
            language, flags = ["-x", "c", "-std=c99", "-pedantic"], [flag for flag in flags if not flag.startswith("-std=")]
        done = subprocess.run([compiler, *language, *WARNINGS, "-fsyntax-only", *flags, source], capture_output=True, text=True)
    return [] if done.returncode == 0 else [f"{', '.join(map(str, headers))}: not compiled:\n{done.stderr}"]


def compile_together(headers, compiler, flags):
    """Lines of what does not compile, but for C, in one source."""
    for_cpp = [header for header in headers if header != FOR_C]
    return compile_only(for_cpp, compiler, flags) + [line for header in headers if header == FOR_C
                                                     for line in compile_only([header], compiler, flags)]


def compile_alone(folder, headers, compiler, flags):
    """Lines of what does not compile alone."""
    needed = {header: frozenset(eigen_of(folder, header)) for header in headers}
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor(os.cpu_count()) as compilers:
        compiled = {frozenset(): None}
        for number, names in enumerate(sorted(set(needed.values()) - {frozenset()}, key=sorted)):
            compiled[names] = Path(work, f"eigen_{number}.h")
            compiled[names].write_text("".join(f"#include <{name}>\n" for name in sorted(names)))
            subprocess.run([compiler, *WARNINGS, *flags, "-x", "c++-header", compiled[names]], check=True)
        found = compilers.map(lambda header: compile_only([header], compiler, flags, compiled[needed[header]]), headers)
        return [line for lines in found for line in lines]


def main():
    arguments = sys.argv[1:]
    alone = arguments[0] == "--alone"
    folder, compiler, *flags = arguments[alone:]
    folder = Path(folder)
    headers = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    print("installed:", *headers)
    problems = [f"{header} is not proxima/NAME.h" for header in headers
                if header != FOR_C and (header.parent != Path("proxima") or header.suffix != ".h")]
    if not 0 < len(set(headers) - {FOR_C}) <= MOST_HEADERS:
        problems.append(f"{len(headers)} headers are installed, at most {MOST_HEADERS} should be")
    for header in headers:
        problems += wrong_includes(folder, header)
    problems += compile_alone(folder, headers, compiler, flags) if alone else compile_together(headers, compiler, flags)
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
