#!/usr/bin/env python3
"""Runs clang-tidy on sources, but not again on one that passed and has not changed since.

    scripts/tidy.py BUILD FILE...      BUILD: a folder with compile_commands.json

Most of the time goes to the headers that a source includes, so up to forty sources of one target are joined to one
that includes them all, or half of them where they cannot be joined. The static analyzer looks only at the source itself,
so it is run on each alone; not on tests, for in the macros of GoogleTest it spends a minute each.

What a source is, is its text with all that it includes, its command, and the rules. Each that passed leaves
an empty file of that hash in BUILD/tidied, one for the analyzer and one for all other rules. A source that BUILD does not compile is checked as its neighbour
in the compile commands would be. Exit status 1 if any source has findings.
"""
import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

TIDY = "clang-tidy-14"
ROOT = Path(__file__).resolve().parent.parent
JOINED = 40
ANALYZER = "clang-analyzer-*"
# A joined source's parts are headers to clang-tidy.
HEADERS = r"--header-filter=(src|apps|tests|bench|fuzz)/.*\.(h|cpp)$"
# What a part of a joined source may do, as each source of its own may: declare again, and end a namespace's names.
BETWEEN_SOURCES = ["readability-redundant-declaration", "readability-duplicate-include", "bugprone-suspicious-include"]
# What tests may do: be slow, and be plain about numbers, bytes and odd characters.
IN_TESTS = ["performance-*", "modernize-use-emplace", "modernize-use-auto", "modernize-pass-by-value",
            "bugprone-integer-division", "bugprone-narrowing-conversions", "bugprone-misplaced-widening-cast",
            "bugprone-implicit-widening-of-multiplication-result", "bugprone-suspicious-memory-comparison",
            "misc-misleading-bidirectional"]


def commands_of(build):
    """By source: the first command that compiles it, without source and output, and its folder."""
    commands = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        words = words[:words.index("-o")] + words[words.index("-o") + 2:]
        words.remove("-c")
        words.remove(entry["file"])
        # With glibc's checks its functions are inline: a test that puts one of its own in place of them would not compile.
        words = [word for word in words if word != "-D_FORTIFY_SOURCE=2"]
        commands.setdefault(Path(entry["file"]), (words, entry["directory"]))
    return commands


def command_of(source, commands):
    if source in commands:
        return commands[source]
    neighbour = max(commands, key=lambda other: (len(os.path.commonpath([source, other])), len(commands[other][0])))
    return commands[neighbour]


def stamp_of(source, command, folder, rules):
    """The name of what says that a source passed; a name that no file has where it does not compile."""
    # With comments, for they can silence a rule; without the checkout's place, for copies of it pass alike.
    text = subprocess.run([*command, "-E", "-CC", "-P", source], cwd=folder, capture_output=True)
    if text.returncode != 0:
        return "does not compile"
    said = " ".join([*command, str(source)]).replace(str(ROOT), ".")
    return hashlib.sha256(rules + said.encode() + text.stdout).hexdigest()


def findings_of(source, command, folder, *options):
    """What clang-tidy prints; None where the source passed."""
    result = subprocess.run([TIDY, "--quiet", *options, str(source), "--", *command[1:]], cwd=folder, capture_output=True, text=True)
    return None if result.returncode == 0 else result.stdout + result.stderr


def is_test(source):
    return (ROOT / "tests") in source.parents


def but_for(rules):
    return "--checks=" + ",".join("-" + rule for rule in rules)


def joined_findings(sources, command, folder, place):
    """What all rules but the analyzer's say of sources together, or of each half where they cannot be joined."""
    allowed = [ANALYZER, *(IN_TESTS if is_test(sources[0]) else [])]
    if len(sources) == 1:
        return findings_of(sources[0], command, folder, but_for(allowed))
    together = place / (hashlib.sha256(" ".join(map(str, sources)).encode()).hexdigest()[:16] + ".cpp")
    together.write_text("".join(f'#include "{source}"\n' for source in sources))
    found = findings_of(together, command, folder, HEADERS, but_for([*allowed, *BETWEEN_SOURCES]))
    if found is None or "clang-diagnostic-" not in found:
        return found
    middle = len(sources) // 2
    halves = [joined_findings(half, command, folder, place) for half in (sources[:middle], sources[middle:])]
    return "\n".join(one for one in halves if one is not None) or None


def guilty_of(sources, found):
    """Which sources findings are about: all where one is in a header, which any of them may include."""
    places = {Path(place) for place in re.findall(r"^(/.+?):\d+:\d+: (?:error|warning): ", found, re.MULTILINE)}
    return places if places and places <= set(sources) else set(sources)


def can_be_joined(source):
    """Sources that include themselves for each instruction set cannot."""
    text = source.read_text()
    return "HWY_TARGET_INCLUDE" not in text and "LLVMFuzzerTestOneInput" not in text and "int main(" not in text


def batches_of(sources, commands):
    """Sources to look at together, each list with the command and folder of all."""
    alike = {}
    for source in sources:
        command, folder = command_of(source, commands)
        own = "" if can_be_joined(source) else str(source)
        alike.setdefault((*command, folder, own), []).append(source)
    for same in alike.values():
        for first in range(0, len(same), JOINED):
            yield same[first:first + JOINED], *command_of(same[first], commands)


def main():
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    build = Path(sys.argv[1]).resolve()
    tidied = build / "tidied"
    tidied.mkdir(exist_ok=True)
    commands = commands_of(build)
    rules = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout
    rules += (ROOT / ".clang-tidy").read_bytes() + repr((BETWEEN_SOURCES, IN_TESTS)).encode()
    sources = [Path(name).resolve() for name in sys.argv[2:]]

    def check(batch):
        """How many sources of the batch there are findings about."""
        wanted, command, folder = batch
        start = time.monotonic()
        stamps = {source: stamp_of(source, command, folder, rules) for source in wanted}
        bad = set()
        said = []

        def pass_or_tell(kind, those, found):
            guilty = guilty_of(those, found) if found is not None else set()
            bad.update(guilty)
            if found is not None:
                said.append(found)
            for source in those:
                if source not in guilty and stamps[source] != "does not compile":
                    (tidied / f"{stamps[source]}.{kind}").touch()

        def new(kind):
            return [source for source in wanted if not (tidied / f"{stamps[source]}.{kind}").exists()]

        together = new("rules")
        if together:
            pass_or_tell("rules", together, joined_findings(together, command, folder, tidied))
        for source in new("analyzer"):
            if not is_test(source):
                pass_or_tell("analyzer", [source], findings_of(source, command, folder, f"--checks=-*,{ANALYZER}"))
        names = " ".join(str(source.relative_to(ROOT)) for source in wanted)
        print(f"{names}: {'FINDINGS' if bad else 'passed'}, {time.monotonic() - start:.0f} s", flush=True)
        for text in said:
            print(text, flush=True)
        return len(bad)

    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as workers:
        bad = sum(workers.map(check, batches_of(sources, commands)))
    print(f"tidy: {len(sources)} sources, {bad} with findings")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
