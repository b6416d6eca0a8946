#!/usr/bin/env python3
"""What users find after an installation: a folder of at most forty headers, each of which compiles alone and
includes the others, Eigen and the standard library only; result.h also tl/expected.hpp. Beside them one for C, which
needs the C library only.

    installed_headers.py INCLUDE_FOLDER COMPILER FLAGS...     exit status 1 where that is not so
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


def includes_eigen(folder, header):
    """Whether a header includes Eigen, itself or by another of ours."""
    names = [name for _, name in INCLUDE.findall((folder / header).read_text())]
    return any(name.startswith("Eigen/") or (name.startswith("proxima/") and includes_eigen(folder, name)) for name in names)


def compile_alone(header, work, compiler, flags):
    """What the compiler says of a source that includes the header twice and nothing else."""
    source = work / f"alone_{header.stem}.cpp"
    source.write_text(2 * f"#include <{header}>\n")
    if header == FOR_C:
        flags = ["-x", "c", "-std=c99", "-pedantic", *(flag for flag in flags if not flag.startswith("-std="))]
    done = subprocess.run([compiler, *flags, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", source], capture_output=True, text=True)
    return [] if done.returncode == 0 else [f"{header} does not compile alone:\n{done.stderr}"]


def compile_each(headers, folder, compiler, flags):
    """All headers, each alone; of those that include Eigen only Eigen is compiled before, once for all."""
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(os.cpu_count()) as compilers:
        work = Path(name)
        eigen = work / "eigen.h"
        eigen.write_text("#include <Eigen/Core>\n")
        # Compiled before, they are not known as headers of the system, whose warnings are left out.
        with_eigen = [*flags, "-Wno-ignored-attributes"]
        subprocess.run([compiler, *with_eigen, "-x", "c++-header", eigen, "-o", f"{eigen}.gch"], check=True)
        with_eigen += ["-include", eigen]
        return [problem for problems in compilers.map(lambda header: compile_alone(
            header, work, compiler, with_eigen if includes_eigen(folder, header) else flags), headers) for problem in problems]


def main():
    folder, compiler, flags = Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    headers = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    print("installed:", *headers)
    problems = [f"{header} is not proxima/NAME.h" for header in headers
                if header != FOR_C and (header.parent != Path("proxima") or header.suffix != ".h")]
    if not 0 < len(set(headers) - {FOR_C}) <= MOST_HEADERS:
        problems.append(f"{len(headers)} headers are installed, at most {MOST_HEADERS} should be")
    for header in headers:
        problems += wrong_includes(folder, header)
    problems += compile_each(headers, folder, compiler, flags)
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
