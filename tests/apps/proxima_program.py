"""Runs the program `proxima` as its users do; the path is in the environment variable PROXIMA, that of a library to be
loaded before it, if any, in PROXIMA_PRELOAD."""
import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

PROXIMA = os.environ.get("PROXIMA", "proxima")
SANITIZED = bool(os.environ.get("PROXIMA_SANITIZE"))  # watched, it is slower, and needs more memory
SECONDS = 1800 if SANITIZED else 300


def environment_of_program(environment=os.environ):
    """What the program is to see in an environment."""
    preload = os.environ.get("PROXIMA_PRELOAD")
    return {**environment, "LD_PRELOAD": preload} if preload else dict(environment)


def run(*arguments, env=os.environ, **options):
    """Runs to the end with stdout and stderr caught as text."""
    return subprocess.run([PROXIMA, *map(str, arguments)], text=True, env=environment_of_program(env),
                          **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "timeout": SECONDS, **options})


def has_signal(pid, kind, number):
    """Whether a signal is in a set of /proc: handled by the process (SigCgt) or waiting for it (ShdPnd)."""
    with open(f"/proc/{pid}/status") as file:
        bits = next(line for line in file if line.startswith(f"{kind}:"))
    return int(bits.split()[1], 16) >> (number - 1) & 1


class ProgramTest(unittest.TestCase):
    """Gives each test an empty folder, and what to expect of the program."""

    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = Path(self._folder.name)

    def file(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def succeed(self, *arguments, **options):
        result = run(*arguments, **options)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        return result.stdout

    def json_of(self, *arguments):
        return json.loads(self.succeed(*arguments, "--json", "-"))

    def refuse(self, *arguments, status=1, says=(), **options):
        """Expects the exit status and one line on stderr that has all of `says`."""
        before = sorted(self.folder.rglob("*"))
        result = run(*arguments, **options)
        self.assertEqual(result.returncode, status, result.stderr)
        self.assertTrue(result.stderr.startswith("proxima: "), result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        for part in [says] if isinstance(says, str) else says:
            self.assertIn(part, result.stderr)
        self.assertEqual(sorted(self.folder.rglob("*")), before, "something was left behind")
        return result.stderr
