#!/usr/bin/env python3
"""No kernel copies or clears memory by `rep movs` or `rep stos`, and none calls the C library's mathematics.

The first two take dozens of cycles to begin, and a table that a function keeps as a local constant is copied by them
in every call. A call to `sqrt` or `floor` saves and loads all vectors in use. Compilers choose these for one
instruction set and not for another, so that only the machine code tells.

    kernel_code.py LIBRARY...      prints each kernel that does, with the instruction; exit status 1 if any
"""
import re
import subprocess
import sys

FUNCTION = re.compile(r"^[0-9a-f]+ <(.*)>:$")
KERNEL = re.compile(r"\bN_(?:AVX3\w*|AVX2|SSE4|SSSE3)::")
# Code that g++ takes for cold has `rep movsl`.
SLOW = re.compile(r"\brep (?:movsq|stos\w*)")
# To a function of the C library, as the linker is told. Copies of kilobytes may be calls; names with an underscore
# in front are what exceptions need.
CALL = re.compile(r"R_X86_64_PLT32\s+(?!mem(?:cpy|set|move)-)([a-z]\w*)-0x")


def slow_kernels(listing):
    """(kernel, instruction) of every slow instruction or call, and how many kernels there are."""
    function = None
    kernels = 0
    found = []
    for line in listing:
        if begins := FUNCTION.match(line):
            function = begins[1] if KERNEL.search(begins[1]) else None
            kernels += function is not None
        elif function and (slow := SLOW.search(line)):
            found.append((function, slow[0]))
        elif function and (call := CALL.search(line)):
            found.append((function, f"call of {call[1]}"))
    return found, kernels


def main(libraries):
    kernels = 0
    broken = []
    for library in libraries:
        listing = subprocess.run(["objdump", "-drC", "--no-show-raw-insn", library], check=True, text=True,
                                 errors="replace", stdout=subprocess.PIPE).stdout.splitlines()
        found, count = slow_kernels(listing)
        broken += found
        kernels += count
    for function, instruction in broken:
        print(f"{function}: {instruction}")
    print(f"{kernels} kernels, {len(broken)} slow instructions and calls")
    return 1 if broken or kernels == 0 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
