#!/usr/bin/env python3
"""Prints docs/options.md: every option of every command, as the program's help has it.

    scripts/option_table.py PROGRAM > docs/options.md
"""
import re
import subprocess
import sys


def help_of(program, *command):
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout


def commands_of(program):
    lines = help_of(program).split("Subcommands:\n")[1].splitlines()
    return [line.split()[0] for line in lines if line.startswith("  ") and line.strip()]


def options_of(program, command):
    """(name, value and default, words) of each option, in the order of the help."""
    column = 32  # of the words, which stand in the next line where what is before them is long
    options = []
    for line in help_of(program, command).split("Options:\n")[1].splitlines():
        if line.startswith(" " * column):
            options[-1] = ["".join(options[-1]), line.strip()]
        elif line.strip():
            options.append([line[:column], line[column:]])
    for left, words in options:
        name, _, value = left.strip().partition(" ")
        value = re.sub(r" ?(Excludes|Needs):.*| \(Env:\w+\)", "", value)
        if name != "-h,--help":
            yield name, value.replace(":in", " in").replace(":INT in", " in").replace(":UINT in", " in").replace(":FLOAT in", " in").strip(), words.strip()


def main():
    rows = {}
    commands = commands_of(sys.argv[1])
    for command in commands:
        for name, value, words in options_of(sys.argv[1], command):
            rows.setdefault((name, value, words), []).append(command)
    print("# All options\n\n`scripts/option_table.py` makes this page of what `--help` prints; a test holds them equal. An option that several commands have is"
          "\none row where it is the same. `=` stands before a default. More on each command is in [command_line.md](command_line.md).\n")
    print("| Option | Value | Commands | Meaning |\n|---|---|---|---|")
    for (name, value, words), users in sorted(rows.items(), key=lambda row: (row[0][0], row[1])):
        who = "all" if len(users) == len(commands) else ", ".join(users)
        cells = [f"`{name}`", f"`{value}`" if value else "", who, words]
        print("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")


if __name__ == "__main__":
    main()
