"""The include rule must hold in a good tree and catch each kind of planted wrong include."""
import tempfile
import unittest
from pathlib import Path

import include_rule

GOOD = {
    "include/proxima/result.h": "#include <string>\n#include <tl/expected.hpp>\n",
    "include/proxima/geometry.h": '#include "proxima/result.h"\n#include <Eigen/Core>\n#include <vector>\n',
    "include/proxima/octree.h": "#include <vector>\n",
    "include/proxima/proxima.h": '#include "proxima/geometry.h"\n#include "proxima/octree.h"\n#include "proxima/result.h"\n',
    "src/base/parallel.h": "",
    "src/base/parallel.cpp": '#include "proxima/result.h"\n#include <tbb/parallel_for.h>\n',
    "src/mesh/mesh.h": '#include "proxima/geometry.h"\n#include <Eigen/Core>\n#include <vector>\n',
    "src/index/region.h": '#include "mesh/mesh.h"\n',
    "src/query/ray.h": '#include "mesh/mesh.h"\n',
    "apps/cli/main.cpp": '#include "cli/model.h"\n#include "query/ray.h"\n#include <CLI/CLI.hpp>\n',
    "apps/cli/model.h": '#include "mesh/mesh.h"\n',
    "apps/viewer/scene.h": "#include <epoxy/gl.h>\n",
}


def problems_with(changes):
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, text in {**GOOD, **changes}.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return include_rule.problems(root)[0]


class IncludeRule(unittest.TestCase):
    def check(self, name, text, *expected):
        found = problems_with({name: text})
        self.assertEqual(len(found), 1, found)
        for part in (name, *expected):
            self.assertIn(part, found[0])

    def test_accepts_a_good_tree(self):
        self.assertEqual(problems_with({}), [])

    def test_catches_a_layer_to_the_right(self):
        self.check("src/base/wrong.h", '\n#include "mesh/mesh.h"\n', ":2:",
                   "base must not include mesh")

    def test_catches_the_index_including_a_query(self):
        self.check("src/index/wrong.h", '#include "query/ray.h"\n', "index must not include query")

    def test_catches_the_library_including_an_app(self):
        self.check("src/query/wrong.h", '#include "cli/model.h"\n', "query must not include apps")

    def test_catches_an_app_including_another(self):
        self.check("apps/cli/wrong.h", '#include "viewer/scene.h"\n', "another app")
        self.check("apps/distributed/wrong.h", '#include "viewer/scene.h"\n', "another app")

    def test_accepts_apps_that_may_include_another(self):
        self.assertEqual(problems_with({"apps/viewer/figure.h": '#include "cli/model.h"\n'}), [])
        self.assertEqual(problems_with({"apps/distributed/ranks.h": '#include "cli/model.h"\n'}), [])
        self.assertEqual(problems_with({"apps/cli/main.cpp": '#include "viewer/scene.h"\n'}), [])

    def test_catches_an_unknown_layer(self):
        self.check("src/utils/wrong.h", "", "utils is no layer")
        self.check("src/wrong.h", "", "src is no layer")

    def test_catches_paths_that_are_not_from_the_root(self):
        self.check("src/mesh/wrong.h", '#include "mesh.h"\n', "no path below")
        self.check("src/mesh/wrong.h", '#include "../base/parallel.h"\n', "no path below")
        self.check("src/mesh/wrong.h", "#  include <base/parallel.h>\n", "our own")

    def test_catches_foreign_headers_out_of_place(self):
        self.check("src/mesh/wrong.h", "#include <tbb/parallel_for.h>\n", "for src/base/parallel.cpp only")
        self.check("src/base/wrong.cpp", "#include <oneapi/tbb.h>\n", "for src/base/parallel.cpp only")
        self.check("src/mesh/wrong.h", "#include <fmt/format.h>\n", "for apps only")
        self.check("src/mesh/wrong.h", "#include <boost/array.hpp>\n", "no library the core may use")

    def test_catches_vector_code_out_of_place(self):
        self.check("src/octree/wrong.cpp", "#include <hwy/highway.h>\n", "for base only")
        self.check("apps/cli/wrong.cpp", "#include <hwy/highway.h>\n", "kernels only")
        for name in ("src/base/wrong.h", "src/octree/snapped_overlap.cpp", "apps/cli/wrong.cpp",
                     "tests/octree/wrong_test.cpp", "bench/wrong.h", "fuzz/wrong.cpp", "examples/wrong.cpp"):
            for header in ("immintrin.h", "x86intrin.h", "xmmintrin.h", "arm_neon.h"):
                self.check(name, f"#include <vector>\n#include <{header}>\n", ":2:", "one processor")

    def test_accepts_vector_code_where_it_belongs(self):
        for name in ("src/base/simd.cpp", "src/octree/snapped_overlap.cpp"):
            self.assertEqual(problems_with({name: "#include <hwy/highway.h>\n"}), [])

    def test_catches_a_public_header_that_shows_the_inside(self):
        good = GOOD["include/proxima/geometry.h"]
        for include, reason in (('"base/parallel.h"', "must not include src/base/parallel.h"),
                                ("<tbb/parallel_for.h>", "not for public headers"),
                                ("<tl/expected.hpp>", "not for public headers"),
                                ("<xxhash.h>", "not for public headers"),
                                ("<hwy/highway.h>", "not for public headers"),
                                ("<immintrin.h>", "one processor")):
            self.check("include/proxima/geometry.h", f"{good}#include {include}\n", ":4:", reason)

    def test_catches_a_public_header_of_a_layer_to_the_right(self):
        self.check("include/proxima/geometry.h", '#include "proxima/octree.h"\n', "geometry must not include octree")
        self.check("src/base/parallel.h", '#include "proxima/geometry.h"\n', "base must not include geometry")

    def test_catches_a_public_header_without_a_layer(self):
        found = problems_with({"include/proxima/odd.h": "", "include/proxima/proxima.h":
                               "".join(f'#include "proxima/{name}.h"\n' for name in ("geometry", "octree", "odd", "result"))})
        self.assertEqual(len(found), 1, found)
        self.assertIn("without a layer", found[0])

    def test_catches_a_public_header_that_everything_leaves_out(self):
        self.check("include/proxima/proxima.h", '#include "proxima/geometry.h"\n#include "proxima/octree.h"\n', "proxima/result.h")

    def test_catches_the_library_including_everything(self):
        self.check("src/mesh/wrong.cpp", '#include "proxima/proxima.h"\n', "for users only")

    def test_catches_circles(self):
        found = problems_with({
            "src/mesh/one.h": '#include "mesh/two.h"\n',
            "src/mesh/two.h": '#include "mesh/three.h"\n',
            "src/mesh/three.h": '#include "mesh/one.h"\n',
        })
        self.assertEqual(len(found), 1, found)
        self.assertIn("circle", found[0])
        for name in ("one.h", "two.h", "three.h"):
            self.assertIn(name, found[0])


if __name__ == "__main__":
    unittest.main()
