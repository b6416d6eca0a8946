#!/usr/bin/env python3
"""Runs clang-tidy on sources, but not again on one that passed and has not changed since.

    scripts/tidy.py BUILD FILE...      BUILD: a folder with compile_commands.json

What a source is, is its text with all that it includes, its command, and the rules. Each that passed leaves
an empty file of that hash in BUILD/tidied. A source that BUILD does not compile is checked as its neighbour
in the compile commands would be. Exit status 1 if any source has findings.
"""
import concurrent.futures
import hashlib
import json
import os
import shlex
import subprocess
import sys
import time
from pathlib import Path

TIDY = "clang-tidy-14"
ROOT = Path(__file__).resolve().parent.parent


def commands_of(build):
    """By source: the first command that compiles it, without source and output, and its folder."""
    commands = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        words = words[:words.index("-o")] + words[words.index("-o") + 2:]
        words.remove("-c")
        words.remove(entry["file"])
        commands.setdefault(Path(entry["file"]), (words, entry["directory"]))
    return commands


def command_of(source, commands):
    if source in commands:
        return commands[source]
    neighbour = max(commands, key=lambda other: (len(os.path.commonpath([source, other])), len(commands[other][0])))
    return commands[neighbour]


def findings_of(source, command, folder, tidied, rules):
    """What clang-tidy prints; None where the source passed."""
    # With comments, for they can silence a rule; without the checkout's place, for copies of it pass alike.
    text = subprocess.run([*command, "-E", "-CC", "-P", source], cwd=folder, capture_output=True)
    if text.returncode != 0:
        return text.stderr.decode()
    said = " ".join([*command, str(source)]).replace(str(ROOT), ".")
    stamp = tidied / hashlib.sha256(rules + said.encode() + text.stdout).hexdigest()
    if stamp.exists():
        return None
    result = subprocess.run([TIDY, "--quiet", str(source), "--", *command[1:]], cwd=folder, capture_output=True, text=True)
    if result.returncode == 0:
        stamp.touch()
        return None
    return result.stdout + result.stderr


def main():
    if len(sys.argv) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    build = Path(sys.argv[1]).resolve()
    tidied = build / "tidied"
    tidied.mkdir(exist_ok=True)
    commands = commands_of(build)
    rules = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout + (ROOT / ".clang-tidy").read_bytes()
    sources = [Path(name).resolve() for name in sys.argv[2:]]

    def check(source):
        start = time.monotonic()
        found = findings_of(source, *command_of(source, commands), tidied, rules)
        print(f"{source.relative_to(ROOT)}: {'passed' if found is None else 'FINDINGS'}, {time.monotonic() - start:.0f} s", flush=True)
        if found is not None:
            print(found, flush=True)
        return found is None

    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as workers:
        passed = list(workers.map(check, sources))
    print(f"tidy: {len(passed)} sources, {passed.count(False)} with findings")
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
