#!/usr/bin/env python3
"""Writes the manual pages and the completion for bash, zsh and fish, from what the program's --help prints.

    scripts/manual.py PROGRAM FOLDER         FOLDER/proxima.1, FOLDER/proxima-COMMAND.1 of each command, FOLDER/proxima.bash,
                                             FOLDER/_proxima for zsh, FOLDER/proxima.fish
"""
import re
import subprocess
import sys
from pathlib import Path

from option_table import commands_of, help_of, options_of


def roff(text):
    """Text as it stands, whatever it begins with."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + escaped if escaped.startswith((".", "'")) else escaped


def entries(title, pairs):
    """A section of bold words with their meaning."""
    lines = [f".SH {title}"]
    for name, value, words in pairs:
        lines += [".TP", f"\\fB{roff(name)}\\fR" + (f" \\fI{roff(value)}\\fR" if value else ""), roff(words)]
    return lines if pairs else []


def section(text, heading):
    """(name, words) of the lines below a heading of a help."""
    found = re.search(rf"^{heading}:\n((?:  .*\n)+)", text, re.MULTILINE)
    pairs = []
    for line in found[1].splitlines() if found else []:
        name, _, words = line.strip().partition("  ")
        pairs.append((name.replace(" REQUIRED", ""), "", words.strip()))
    return pairs


def page(name, version, summary, usage, *sections):
    head = [f'.TH {name.upper()} 1 "" "Proxima {version}" "User Commands"', ".SH NAME",
            f"{roff(name)} \\- {roff(summary[0].lower() + summary[1:].rstrip('.'))}", ".SH SYNOPSIS",
            f"\\fB{roff(name.replace('-', ' ', 1))}\\fR {roff(usage)}"]
    return "\n".join(head + [line for lines in sections for line in lines]) + "\n"


def write_pages(program, folder):
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.split()[0]
    text, commands = help_of(program), commands_of(program)
    several = [(f"proxima-{name}(1)", "", words) for name, _, words in section(text, "Subcommands")]
    (folder / "proxima.1").write_text(page(
        "proxima", version, text.splitlines()[0], "COMMAND [OPTIONS]", entries("COMMANDS", several),
        entries("OPTIONS", section(text, "Options"))))
    for command in commands:
        text = help_of(program, command)
        usage = re.search(r"^Usage: proxima \S+ (.*)$", text, re.MULTILINE)[1]
        (folder / f"proxima-{command}.1").write_text(page(
            f"proxima-{command}", version, text.splitlines()[0], usage, entries("ARGUMENTS", section(text, "Positionals")),
            entries("OPTIONS", list(options_of(program, command))), [".SH SEE ALSO", "\\fBproxima\\fR(1)"]))


def listed_values(value):
    """The values of an option that has a list of them."""
    found = re.search(r"\{([\w,-]+)\}", value)
    return found[1].split(",") if found else []


def quoted(text):
    """A word of zsh, whatever is in it."""
    return "'" + text.replace("'", "'\\''") + "'"


def quoted_for_fish(text):
    return quoted(text.replace("\\", "\\\\"))


def write_zsh(program, folder):
    def spec(name, value, words):
        meaning = re.sub(r"([\[\]:\\])", r"\\\1", words)
        listed = listed_values(value)
        what = "" if not value else f":{re.sub(r'[^A-Z]', '', value.split(' in ')[0].split(':')[0]) or 'value'}:" + (f"({' '.join(listed)})" if listed else "_files")
        return quoted(f"*{name}[{meaning}]{what}")

    commands = section(help_of(program), "Subcommands")
    described = " ".join(quoted(name + ":" + words.replace(":", "\\:")) for name, _, words in commands)
    lines = ["#compdef proxima", "# Completion of the program proxima for zsh.", "_proxima()", "{", "  local -a commands options",
             f"  commands=({described})", "  if ((CURRENT == 2)); then", "    _describe command commands", "    return", "  fi",
             "  local command=$words[2]", "  shift words", "  ((CURRENT -= 1))", "  case $command in"]
    for command, _, _ in commands:
        specs = " ".join(spec(*option) for option in options_of(program, command))
        lines.append(f"    {command}) options=({specs}) ;;")
    lines += ["  esac", "  _arguments -S $options '--help[Print what the command does and its options]' '*:file:_files'", "}", '_proxima "$@"']
    (folder / "_proxima").write_text("\n".join(lines) + "\n")


def write_fish(program, folder):
    lines = ["# Completion of the program proxima for fish."]
    for command, _, words in section(help_of(program), "Subcommands"):
        lines.append(f"complete -c proxima -f -n __fish_use_subcommand -a {command} -d {quoted_for_fish(words)}")
        for name, value, meaning in options_of(program, command):
            listed = listed_values(value)
            takes = f" -x -a '{' '.join(listed)}'" if listed else " -r" if value else ""
            lines.append(f"complete -c proxima -n '__fish_seen_subcommand_from {command}' -l {name.removeprefix('--')}{takes} -d {quoted_for_fish(meaning)}")
    (folder / "proxima.fish").write_text("\n".join(lines) + "\n")


def write_completion(program, folder):
    """Commands, their options, and the values of options that have a list of them; files everywhere else."""
    cases = []
    for command in commands_of(program):
        options = [(name, value) for name, value, _ in options_of(program, command)]
        cases.append(f"    {command}) options='{' '.join(name for name, _ in options)} --help' ;;")
        for name, value in options:
            if listed := listed_values(value):
                cases.append(f"    {command}{name}) values='{' '.join(listed)}' ;;")
    (folder / "proxima.bash").write_text(f"""# Completion of the program proxima for bash.
_proxima()
{{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} command=${{COMP_WORDS[1]}} options values=
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W '{' '.join(commands_of(program))} --help --version' -- "$word")
    return
  fi
  _proxima_options "$command"
  if [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
  else
    _proxima_options "$command$before"
    if [[ $values ]]; then
      mapfile -t COMPREPLY < <(compgen -W "$values" -- "$word")
    fi
  fi
}}

_proxima_options()
{{
  case $1 in
{chr(10).join(cases)}
  esac
}}

complete -o default -F _proxima proxima
""")


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    write_pages(program, folder)
    write_completion(program, folder)
    write_zsh(program, folder)
    write_fish(program, folder)


if __name__ == "__main__":
    main()
