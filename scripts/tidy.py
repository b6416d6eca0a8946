#!/usr/bin/env python3
"""Runs clang-tidy on sources, but not again on one that passed and has not changed since.

    scripts/tidy.py BUILD FILE...      BUILD: a folder with compile_commands.json

Most of the time goes to the headers that a source includes, so up to forty sources of one target are pasted into one
that is checked as a whole; those that do not compile with the others are pasted together in their turn. That names of
one source hide those of another is allowed there. The static analyzer looks at no tests, for in the macros of GoogleTest
it spends a minute each.

What a source is, is its text with all that it includes, its command, and the rules. Each that passed leaves an empty file
of that hash in BUILD/tidied. A source that BUILD does not compile is checked as its neighbour in the compile commands
would be. Exit status 1 if any source has findings.
"""
import concurrent.futures
import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

TIDY = "clang-tidy-14"
ROOT = Path(__file__).resolve().parent.parent
JOINED = 40
ANALYZER = "clang-analyzer-*"
# What sources in one may do, as each source of its own may: declare and include again, and hide the names of another.
BETWEEN_SOURCES = ["readability-redundant-declaration", "readability-duplicate-include", "bugprone-suspicious-include"]
HIDING = "-Wno-shadow"
# What each fuzzer has one of, so that those in one file get names of their own. Programs cannot: rules ask more of main().
FUZZER = "LLVMFuzzerTestOneInput"
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


class Paste:
    """Sources pasted into one file in `place`, or a source alone as it is."""

    def __init__(self, sources, command, folder, place):
        self.sources = sources
        self.file = sources[0]
        self.command = command
        self.folder = folder
        self.lines = [(sources[0], 0)]  # of each pasted line: its source and its number there
        if len(sources) == 1:
            return
        texts = []
        self.lines = []
        for name, source in enumerate(sources):
            text = source.read_text().splitlines()
            numbers = list(range(1, len(text) + 1))
            if any(FUZZER in line for line in text):
                text = [f"#define {FUZZER} fuzz_one_input_{name}", *text, f"#undef {FUZZER}"]
                numbers = [1, *numbers, numbers[-1]]
            self.lines += [(source, number) for number in numbers]
            texts.append(text)
        own = own_rules(sources[0])
        if own:  # clang-tidy looks for them in the folders above the file
            place = place / own.parent.name
            place.mkdir(exist_ok=True)
            shutil.copy(own, place)
        self.file = place / (hashlib.sha256(" ".join(map(str, sources)).encode()).hexdigest()[:16] + ".cpp")
        self.file.write_text("".join(line + "\n" for text in texts for line in text))
        folders = dict.fromkeys(source.parent for source in sources)
        self.command = [*command, HIDING, *(f"-iquote{folder}" for folder in folders)]

    def told(self, text):
        """With the sources' names and lines in place of the file's."""
        if len(self.sources) == 1:
            return text
        return re.sub(rf"^{re.escape(str(self.file))}:(\d+)", lambda at: "{}:{}".format(*self.lines[int(at[1]) - 1]), text,
                      flags=re.MULTILINE)

    def errors(self):
        """What the compiler says where it does not compile."""
        result = subprocess.run([*self.command, "-fsyntax-only", str(self.file)], cwd=self.folder, capture_output=True, text=True)
        return self.told(result.stderr) if result.returncode != 0 else ""

    def findings(self):
        """What clang-tidy prints; None where all passed."""
        allowed = BETWEEN_SOURCES if len(self.sources) > 1 else []
        if is_test(self.sources[0]):
            allowed = [*allowed, *IN_TESTS, ANALYZER]
        checks = "--checks=" + ",".join("-" + rule for rule in allowed)
        result = subprocess.run([TIDY, "--quiet", checks, str(self.file), "--", *self.command[1:]], cwd=self.folder,
                                capture_output=True, text=True)
        return None if result.returncode == 0 else self.told(result.stdout + result.stderr)


def own_rules(source):
    """The file of rules for the source's folder; None where only those of all sources hold."""
    folders = [folder for folder in source.parents if ROOT in folder.parents]
    return next((folder / ".clang-tidy" for folder in folders if (folder / ".clang-tidy").exists()), None)


def is_test(source):
    return (ROOT / "tests") in source.parents


def pastes_of(sources, command, folder, place):
    """Pastes that compile, of all sources: those with errors among the others are pasted after them."""
    while sources:
        together = sources
        while True:
            paste = Paste(together, command, folder, place)
            errors = paste.errors() if len(together) > 1 else ""
            if not errors:
                break
            wrong = places_of(errors)
            rest = [source for source in together if source not in wrong]
            together = rest if 0 < len(rest) < len(together) else together[:len(together) // 2]
        yield paste
        sources = [source for source in sources if source not in together]


def places_of(found):
    """The files that findings or errors are in."""
    return {Path(place) for place in re.findall(r"^(/.+?):\d+:\d+: (?:fatal error|error|warning): ", found, re.MULTILINE)}


def guilty_of(sources, found):
    """Which sources findings are about: all where one is in a header, which any of them may include."""
    places = places_of(found)
    return places if places and places <= set(sources) else set(sources)


def can_be_joined(source):
    """Sources that include themselves for each instruction set cannot."""
    text = source.read_text()
    return "HWY_TARGET_INCLUDE" not in text and "int main(" not in text


def batches_of(sources, commands):
    """Sources to look at together, of one command and one set of rules, each list with the command and folder of all."""
    alike = {}
    for source in sources:
        command, folder = command_of(source, commands)
        own = "" if can_be_joined(source) else str(source)
        alike.setdefault((*command, folder, own, own_rules(source)), []).append(source)
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
    rules += (ROOT / ".clang-tidy").read_bytes() + repr((BETWEEN_SOURCES, IN_TESTS, HIDING)).encode()
    sources = [Path(name).resolve() for name in sys.argv[2:]]

    def check(batch):
        """How many sources of the batch there are findings about."""
        wanted, command, folder = batch
        start = time.monotonic()
        own = own_rules(wanted[0])
        holding = rules + (own.read_bytes() if own else b"")
        stamps = {source: stamp_of(source, command, folder, holding) for source in wanted}
        bad = set()
        said = []

        new = [source for source in wanted if not (tidied / stamps[source]).exists()]
        for paste in pastes_of(new, command, folder, tidied):
            found = paste.findings()
            guilty = guilty_of(paste.sources, found) if found is not None else set()
            bad.update(guilty)
            if found is not None:
                said.append(found)
            for source in paste.sources:
                if source not in guilty and stamps[source] != "does not compile":
                    (tidied / stamps[source]).touch()
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
