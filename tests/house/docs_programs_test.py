"""The programs of the manual that are no examples: those in C and Python run, those in C++ compile."""
import ctypes
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

INCLUDES, COMPILER, LIBRARY, ROOT = (sys.argv.pop() for _ in range(4))
ROOT, LIBRARY = Path(ROOT).resolve(), Path(LIBRARY)

# What the lines of docs/haptic_scenes.md are given.
IN_A_SCENE = """const Box& bounds, const TriangleMesh& mesh, const RigidTransform& pose, const RigidTransform& next, const WorkspaceMap& map,
    const Result<TouchBody>& other_body, std::span<const Vec3> positions, const WorkspaceMap& left_map, const WorkspaceMap& right_map,
    const DeviceLimits& left_limits, const DeviceLimits& right_limits"""


def programs(page, language):
    found = re.findall(rf"^```{language}\n(.*?)```", (ROOT / "docs" / page).read_text(), re.DOTALL | re.MULTILINE)
    assert found, page
    return "\n".join(found)


class Programs(unittest.TestCase):
    def run_in(self, folder, *command, **options):
        done = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True, **options)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_c(self):
        with tempfile.TemporaryDirectory() as folder:
            library, mesh = ctypes.CDLL(str(LIBRARY)), ctypes.c_void_p()
            library.proxima_mesh_sample(b"icosphere:5", ctypes.byref(mesh))
            library.proxima_mesh_write(mesh, f"{folder}/bunny.ply".encode())
            library.proxima_mesh_destroy(mesh)
            Path(folder, "program.c").write_text("#include <proxima/c/proxima.h>\n#include <stdio.h>\nint main(void)\n{\n" +
                                                 programs("c_interface.md", "c") + 'return printf("%.3f", distance) < 0;\n}\n')
            self.run_in(folder, COMPILER, "-x", "c", "-std=c99", "-Wall", "-Werror", f"-I{ROOT}/include", "program.c", "-x", "none", LIBRARY,
                        f"-Wl,-rpath,{LIBRARY.parent}")
            self.assertEqual(self.run_in(folder, "./a.out"), "-0.900")  # 0.1 off the middle of a sphere

    def test_python_without_a_module(self):
        code = programs("c_interface.md", "python") + "assert mesh.value\n"
        self.run_in(LIBRARY.parent, sys.executable, "-c", code, env={"LD_LIBRARY_PATH": str(LIBRARY.parent)})

    def test_cpp(self):
        source = "\n".join(["#include <proxima/proxima.h>", '#include "thesis/octree_generation/overlap_tests.h"', "using namespace proxima;",
                            programs("how_to_extend.md", "cpp"), "void with_a_device() {", programs("devices.md", "cpp"), "}",
                            f"void in_a_scene({IN_A_SCENE}) {{", programs("haptic_scenes.md", "cpp"), "}"])
        self.run_in(ROOT, COMPILER, "-std=c++20", "-fsyntax-only", "-x", "c++", *(f"-I{folder}" for folder in INCLUDES.split(":") if folder),
                    f"-I{ROOT}/src", "-", input=source)

    def test_a_kernel(self):
        kernel, shared = re.findall(r"^```cpp\n(.*?)```", (ROOT / "docs/kernels.md").read_text(), re.DOTALL | re.MULTILINE)
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "x-inl.h").write_text(shared.replace("// what several kernels share", "inline void step() {}"))
            Path(folder, "largest.cpp").write_text(kernel.replace("#include <hwy/highway.h>\n", '#include <hwy/highway.h>\n#include "x-inl.h"\n', 1)
                                                   .replace("    namespace hn", "    step();\n    namespace hn", 1))
            Path(folder, "main.cpp").write_text("""#include <cstddef>
                namespace proxima { double largest(const double*, std::size_t); }
                int main()
                {
                    double numbers[24] = {};
                    for (int i = 0; i < 24; ++i) {
                        numbers[i] = 5;
                        if (proxima::largest(numbers, 24) != 5) return 1;
                        numbers[i] = -1;
                    }
                }""")
            self.run_in(folder, COMPILER, "-std=c++20", "-O1", "-Wall", "-Werror", f"-I{folder}", "largest.cpp", "main.cpp", "-lhwy")
            self.run_in(folder, "./a.out")

    def test_several_processes(self):
        program = LIBRARY.parents[2] / "apps/distributed/proxima-mpi"
        commands = [line for block in re.findall(r"^```sh\n(.*?)```", (ROOT / "docs/distributed.md").read_text(), re.DOTALL | re.MULTILINE)
                    for line in block.splitlines()]
        self.assertGreaterEqual(len(commands), 4)
        if not program.exists() or not shutil.which("mpirun"):
            self.skipTest("proxima-mpi was not built")
        for command in commands:
            words = shlex.split(re.sub(r"torus:\d+x\d+", "torus:200x100", command))  # for larger ones take minutes
            self.assertEqual([words[0], Path(words[3]).name], ["mpirun", "proxima-mpi"])
            words[3] = program
            self.run_in(ROOT, *words, env={
                **os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_btl_vader_single_copy_mechanism": "none"})


if __name__ == "__main__":
    unittest.main()
