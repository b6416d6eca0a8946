#!/bin/bash
# Run by scripts/package in a bare Debian, whose folder /packages has the packages and /program a main.cpp.
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
quietly() { "$@" >/tmp/said 2>&1 || { cat /tmp/said; exit 1; }; }
rm -f /etc/dpkg/dpkg.cfg.d/excludes
quietly apt-get update
quietly apt-get install -y --no-install-recommends /packages/*.deb
echo "installed: $(dpkg-query -W -f '${Package} ' libproxima0.1 libproxima-dev proxima-tools python3-proxima proxima-doc)"
dpkg -l | grep -c '^ii' | sed 's/$/ packages in all/'

cd /tmp
proxima --version
proxima closest icosphere:3 --point 0,0,3 | sed -n 1,3p
proxima octree cube --quiet --picture cube.png
cat >/tmp/mesh.off <<'EOF'
OFF
4 4 0
0 0 0
1 0 0
0 1 0
0 0 1
3 0 2 1
3 0 1 3
3 1 2 3
3 2 0 3
EOF
python3 - <<'EOF'
import numpy as np
import proxima
from proxima.compat.trimesh import ProximityQuery

mesh = proxima.Mesh.read("/tmp/mesh.off")
index = proxima.Index(mesh, signs=True)
print("from Python:", proxima.__file__, index.signed_distance([[0.1, 0.2, 0.3], [2, 0, 0]]))
assert len(proxima.Mesh.read("/program/two_tetrahedra.glb").faces) == 8
assert ProximityQuery(mesh).signed_distance([[0.1, 0.2, 0.3]])[0] > 0
EOF

quietly apt-get install -y --no-install-recommends man-db bash-completion zsh fish
for page in proxima proxima-octree proxima-touch; do
  [ "$(man --warnings "$page" 2>/tmp/warnings | wc -l)" -gt 10 ] && [ ! -s /tmp/warnings ] || { echo "manual page $page"; cat /tmp/warnings; exit 1; }
done
bash -c 'source /usr/share/bash-completion/completions/proxima; COMP_WORDS=(proxima touch --gu); COMP_CWORD=2; _proxima; [ "${COMPREPLY[*]}" = --guard ]'
[ "$(fish -c 'complete -C "proxima touch cube --gu"' | cut -f 1)" = --guard ]
zsh -c 'autoload -U compinit; compinit -u -D; [ "$_comps[proxima]" = _proxima ] && autoload +X _proxima'
echo "manual pages open, and the completions of bash, zsh and fish are there"

quietly apt-get install -y --no-install-recommends g++ cmake make pkg-config
cd /program
cat >CMakeLists.txt <<'EOF'
cmake_minimum_required(VERSION 3.25)
project(program CXX)
find_package(proxima REQUIRED)
add_executable(program main.cpp)
target_link_libraries(program PRIVATE proxima::proxima)
EOF
quietly cmake -B build -DCMAKE_BUILD_TYPE=Release
quietly cmake --build build
quietly g++ main.cpp -o by_pkg_config $(pkg-config --cflags --libs proxima)
for program in build/program ./by_pkg_config; do
  "$program" /tmp/mesh.off
  "$program" two_tetrahedra.glb # by assimp, which the library opens now
  [[ $(ldd "$program") == *'libproxima.so.0.1 => /lib'* ]] || { ldd "$program"; exit 1; }
done
echo "the README's program works, by CMake and by pkg-config"
quietly apt-get remove -y libproxima0.1 proxima-tools python3-proxima proxima-doc
left=$(find /usr/lib/python3/dist-packages/proxima /usr/lib/*/proxima /usr/include/proxima 2>/dev/null || true)
[ -z "$left" ] || { echo "left behind: $left"; exit 1; }
echo "removed without a trace"
