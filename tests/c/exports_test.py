"""The C library exports the functions of its header and nothing else, and has everything else inside but what the
system has: no assimp, no C++ library."""
import re
import subprocess
import sys
from pathlib import Path

library, header = sys.argv[1:]


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


exported = {line.split()[-1].split("@")[0] for line in output("nm", "-D", "--defined-only", library).splitlines()}
exported = {name for name in exported if not name.startswith("PROXIMA_C_")}  # the version's own name
text = re.sub(r"/\*.*?\*/", "", Path(header).read_text(), flags=re.DOTALL)
declared = set(re.findall(r"PROXIMA_C_API [^;]*?\b(proxima_\w+)\(", text))
needed = set(re.findall(r"NEEDED.*\[(.*)\]", output("readelf", "-d", library)))
foreign = {name for name in needed if re.match(r"libassimp|libstdc\+\+", name)}
size = Path(library).stat().st_size
print(f"{len(declared)} functions, {size / 1e6:.1f} MB, needs {' '.join(sorted(needed))}")
if exported != declared:
    sys.exit(f"exported only: {sorted(exported - declared)}; declared only: {sorted(declared - exported)}")
if len(declared) < 40:
    sys.exit(f"only {len(declared)} functions found in the header")
if foreign:
    sys.exit(f"needs {sorted(foreign)}")
