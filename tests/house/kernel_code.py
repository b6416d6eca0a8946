#!/usr/bin/env python3
"""No kernel copies or clears memory by `rep movs` or `rep stos`.

Both take dozens of cycles to begin, and a table that a function keeps as a local constant is copied by them in
every call. Compilers choose them for one instruction set and not for another, so that only the machine code tells.

    kernel_code.py LIBRARY...      prints each kernel that does, with the instruction; exit status 1 if any
"""
import re
import subprocess
import sys

FUNCTION = re.compile(r"^[0-9a-f]+ <(.*)>:$")
KERNEL = re.compile(r"\bN_(?:AVX3\w*|AVX2|SSE4|SSSE3)::")
# Code that g++ takes for cold has `rep movsl`.
SLOW = re.compile(r"\brep (?:movsq|stos\w*)")


def slow_kernels(listing):
    """(kernel, instruction) of every slow instruction, and how many kernels there are."""
    function = None
    kernels = 0
    found = []
    for line in listing:
        if begins := FUNCTION.match(line):
            function = begins[1] if KERNEL.search(begins[1]) else None
            kernels += function is not None
        elif function and (slow := SLOW.search(line)):
            found.append((function, slow[0]))
    return found, kernels


def main(libraries):
    kernels = 0
    broken = []
    for library in libraries:
        listing = subprocess.run(["objdump", "-dC", "--no-show-raw-insn", library], check=True, text=True,
                                 errors="replace", stdout=subprocess.PIPE).stdout.splitlines()
        found, count = slow_kernels(listing)
        broken += found
        kernels += count
    for function, instruction in broken:
        print(f"{function}: {instruction}")
    print(f"{kernels} kernels, {len(broken)} slow instructions")
    return 1 if broken or kernels == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
