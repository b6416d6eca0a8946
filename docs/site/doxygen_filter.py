"""Doxygen's filter for our headers: their plain comments at the top, and all comments of the header for C, become documentation.

    doxygen_filter.py HEADER
"""
import re
import sys
from pathlib import Path

path = Path(sys.argv[1])
text = path.read_text()
if path.parent.name == "c":
    text = re.sub(r"^(\s*)/\*(?!\*)", r"\1/**", text, flags=re.MULTILINE)
    text = re.sub(r"(?<=\S)(\s+)/\*(?!\*)", r"\1/**<", text)
    text = text.replace("/**", "/** \\file\n *", 1)
    # One name for a type and its tag would be documented twice.
    text = re.sub(r"^typedef (enum|struct) (\w+) \{([^}]*)\} \2;", r"\1 \2 {\3};", text, flags=re.MULTILINE)
else:
    lines = text.split("\n")
    end = next(number for number, line in enumerate(lines) if not line.startswith("//"))
    head = ["/// \\file", *(line.replace("//", "///", 1) for line in lines[:end])]
    text = "\n".join(head + lines[end:])
sys.stdout.write(text)
