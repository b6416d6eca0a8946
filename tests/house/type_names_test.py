"""Names of types must be told apart where that matters, and only there."""
import tempfile
import unittest
from pathlib import Path

import type_names


def problems_with(files):
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            path = Path(folder) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return type_names.problems(folder)[0]


def named(name, space="proxima"):
    return f"namespace {space} {{\n\nstruct {name} {{\n    int x;\n}};\n\n}} // namespace {space}\n"


def unnamed(name):
    return f"namespace proxima {{\n\nnamespace {{\n\nclass {name} final : public Base {{\n}};\n\n}} // namespace\n\n}} // namespace proxima\n"


class TypeNames(unittest.TestCase):
    def test_two_headers_may_not_define_one_name(self):
        found, = problems_with({"src/a/x.h": named("Gap"), "src/b/y.h": named("Gap")})
        for part in ("src/a/x.h", "src/b/y.h", "proxima::Gap"):
            self.assertIn(part, found)

    def test_nor_may_kernels_of_two_sources(self):
        space = "proxima::HWY_NAMESPACE"
        self.assertEqual(len(problems_with({"src/a/x.cpp": named("Block", space), "src/b/y.cpp": named("Block", space)})), 1)

    def test_unnamed_namespaces_clash_within_a_folder_only(self):
        self.assertEqual(len(problems_with({"src/a/x.cpp": unnamed("Walk"), "src/a/y.cpp": unnamed("Walk")})), 1)
        self.assertEqual(problems_with({"src/a/x.cpp": unnamed("Walk"), "src/b/y.cpp": unnamed("Walk")}), [])

    def test_what_defines_nothing_does_not_count(self):
        declared = "namespace proxima {\nstruct Gap;\nclass Gap::State {\n};\ntemplate <class Gap>\nvoid f(Gap);\n} // namespace proxima\n"
        self.assertEqual(problems_with({"src/a/x.h": named("Gap"), "src/a/y.h": declared}), [])

    def test_other_namespaces_are_other_names(self):
        self.assertEqual(problems_with({"src/a/x.h": named("Gap"), "src/b/y.h": named("Gap", "proxima::detail")}), [])

    def test_exported_and_hidden_types_count(self):
        exported = "namespace PROXIMA_EXPORT proxima {\nclass PROXIMA_HIDDEN Gap {\n};\n} // namespace proxima\n"
        self.assertEqual(len(problems_with({"src/a/x.h": named("Gap"), "src/a/y.h": exported})), 1)


if __name__ == "__main__":
    unittest.main()
