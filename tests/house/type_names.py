#!/usr/bin/env python3
"""One name, one type.

Two types of one name in one namespace break programs that see both, and where only the linker sees both it
takes the functions of one for those of the other, without a word. Types in unnamed namespaces clash where a
build joins the sources of a folder.

    type_names.py ROOT      prints each name that stands for two types; exit status 1 if any
"""
import re
import sys
from collections import defaultdict
from pathlib import Path

TYPE = re.compile(r"^(?:struct|class|enum class|union)\s+(?:alignas\([^)]*\)\s+)?(?:PROXIMA_HIDDEN\s+)?(\w+)(?!\w|::)(?:\s+final)?\s*(?::(?!:)|\{|$)[^;]*$")
OPENS = re.compile(r"^namespace\s*(?:PROXIMA_EXPORT\s+)?([\w:]*)\s*\{[^}]*$")


def types_of(text):
    """(namespace, name) of every type defined there; the format keeps them at the start of a line."""
    spaces = []
    for line in text.splitlines():
        opens = OPENS.match(line)
        if opens:
            spaces.append(opens[1])
        elif line.startswith("} // namespace"):
            spaces.pop()
        elif found := TYPE.match(line):
            yield "::".join(spaces), "" in spaces, found[1]


def problems(root):
    """What is wrong below src/ and apps/, and how many types were seen."""
    root = Path(root)
    places = defaultdict(set)
    for folder in ("src", "apps"):
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            for space, is_unnamed, name in types_of(file.read_text()):
                scope = file.parent.relative_to(root).as_posix() if is_unnamed else ""
                places[space, scope, name].add(file.relative_to(root).as_posix())
    found = [f"{' and '.join(sorted(files))}: {space}::{name} stands for {len(files)} types; rename all but one"
             for (space, _, name), files in places.items() if len(files) > 1]
    return sorted(found), len(places)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    found, count = problems(sys.argv[1])
    if count == 0:
        found = [f"{sys.argv[1]}: no types seen: give the root of the sources"]
    print("\n".join(found) if found else f"{count} types, each with a name of its own")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
