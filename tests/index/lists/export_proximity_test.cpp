// VTK reads exported proximity octrees as the cells that queries end in.
#include "index/lists/export_proximity.h"

#include "base/text.h"
#include "code_of.h"
#include "folder_test.h"
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/proximity_lists.h"
#include "index/test_meshes.h"
#include "octree/exported_leaves.h"
#include "proxima/closest_feature.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <bit>
#include <gtest/gtest.h>

namespace proxima::export_proximity_test {
namespace {

/// The leaf of the point in the middle of a deepest cell, found as a query finds it.
struct Leaf {
    std::uint64_t word = 0;
    int depth = 0;
};

Leaf leaf_at(const MeshIndex& octree, const std::array<std::uint32_t, 3>& cell, int depth)
{
    const int table_depth = octree.parts().lists()->table_depth();
    const auto bit = [&](std::size_t axis, int level) {
        return static_cast<std::size_t>(level <= depth ? cell[axis] >> (depth - level) & 1U : 0);
    };
    std::size_t place = 0;
    for (std::size_t axis : {2U, 1U, 0U})
        for (int level = 1; level <= table_depth; ++level) place = place << 1U | bit(axis, level);
    Leaf leaf{octree.parts().lists()->arrays().table[place], table_depth};
    while (!proximity_word::is_leaf(leaf.word)) {
        ++leaf.depth;
        leaf.word = octree.parts().lists()->arrays().nodes[leaf.word + (bit(0, leaf.depth) |
                                                                        bit(1, leaf.depth) << 1U |
                                                                        bit(2, leaf.depth) << 2U)];
    }
    return leaf;
}

/// Triangles and blocks of a leaf.
std::array<std::uint32_t, 2> sizes(const MeshIndex& octree, std::uint64_t word)
{
    if (word == proximity_word::search) return {0, 0};
    if (!proximity_word::is_run(word))
        return {static_cast<std::uint32_t>(std::popcount(proximity_word::mask(word))), 1};
    const RunEntry* const run =
        &octree.parts().lists()->arrays().runs[proximity_word::position(word)];
    std::uint32_t length = 0;
    for (std::uint32_t i = 1; i <= run->position; ++i)
        length += static_cast<std::uint32_t>(std::popcount(run[i].mask));
    return {length, run->position};
}

/// Each printed leaf is compared with what a query finds in its lowest deepest cell; sizes and
/// number of leaves tell that they are all.
void expect_leaves(const MeshIndex& octree, const std::string& format,
                   const std::vector<std::string>& lines)
{
    const auto max_depth = static_cast<int>(octree.parts().lists()->statistics().max_depth);
    const RootFrame& frame = octree.parts().lists()->frame();
    const Vec3 lower = frame.center - Vec3::Constant(frame.half);
    std::size_t leaves = 0;
    std::uint64_t references = 0;
    double volume = 0;
    for (const std::string& line : lines) {
        if (line.rfind("root", 0) == 0) {
            std::string root = "root";
            for (const double side : {0.0, 2.0}) {
                for (int axis = 0; axis < 3; ++axis)
                    root += concat(",", testing::hex(lower[axis] + side * frame.half));
            }
            EXPECT_EQ(line, root);
            continue;
        }
        std::vector<double> numbers;
        for (std::size_t at = 0; at < line.size() + 1;) {
            const std::size_t comma = std::min(line.find(',', at), line.size());
            numbers.push_back(std::strtod(line.substr(at, comma - at).c_str(), nullptr));
            at = comma + 1;
        }
        ASSERT_EQ(numbers.size(), 9U) << line;
        const auto depth = static_cast<int>(numbers[8]);
        std::array<std::uint32_t, 3> cell{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto k = static_cast<Eigen::Index>(axis);
            const auto part = [&](double coordinate) {
                return format == "htg" ? coordinate / 0x1p20
                                       : (coordinate - lower[k]) / (2 * frame.half);
            };
            const double place = part(numbers[axis]) * std::ldexp(1.0, max_depth);
            cell[axis] = static_cast<std::uint32_t>(std::lround(place));
            ASSERT_NEAR(part(numbers[axis + 3]) - part(numbers[axis]), std::ldexp(1.0, -depth),
                        1e-9);
        }
        const Leaf leaf = leaf_at(octree, cell, max_depth);
        const auto [length, blocks] = sizes(octree, leaf.word);
        ASSERT_EQ(length, numbers[6]) << line;
        ASSERT_EQ(blocks, numbers[7]) << line;
        // Above the table a leaf's depth is not seen from there.
        if (leaf.depth > octree.parts().lists()->table_depth()) {
            ASSERT_EQ(depth, leaf.depth);
        } else {
            ASSERT_LE(depth, octree.parts().lists()->table_depth());
        }
        ++leaves;
        references += length;
        volume += std::ldexp(1.0, -3 * depth);
    }
    EXPECT_EQ(leaves, octree.parts().lists()->statistics().leaves);
    EXPECT_EQ(references, octree.parts().lists()->statistics().references);
    EXPECT_EQ(volume, 1.0);
    EXPECT_TRUE(std::adjacent_find(lines.begin(), lines.end()) == lines.end());
}

class ExportProximity : public FolderTest {};

TEST_F(ExportProximity, IsReadBackLeafByLeaf)
{
    const TriangleMesh torus = testing::torus_mesh(1.0, 0.3, 24, 12);
    const TriangleMesh one = sample_mesh("cube").value();
    const std::vector<MeshIndex> octrees = {
        testing::listed_index(torus, {.list_bytes = 225 * torus.triangle_count()}).value(),
        testing::listed_index(torus, {.list_bytes = 4000 * torus.triangle_count()}).value(),
        testing::listed_index(one, {.max_depth = 0}).value()};
    ASSERT_GT(octrees[0].parts().lists()->arrays().runs.size() +
                  octrees[1].parts().lists()->arrays().runs.size(),
              0U);
    ASSERT_GT(octrees[1].parts().lists()->table_depth(), 0);
    ASSERT_EQ(octrees[2].parts().lists()->statistics().leaves, 1U);
    for (const std::string format : {"vtu", "htg"}) {
        std::vector<std::filesystem::path> paths;
        for (const MeshIndex& octree : octrees) {
            paths.push_back(path(concat(paths.size(), ".", format)));
            const Status status = export_proximity(*octree.parts().lists(), paths.back());
            ASSERT_TRUE(status) << describe(status.error());
        }
        const testing::Output found = testing::read_by_python(paths);
        if (found.status == 77) GTEST_SKIP() << found.last_line;
        ASSERT_EQ(found.status, 0) << found.last_line;
        ASSERT_EQ(found.files.size(), octrees.size());
        for (std::size_t i = 0; i < octrees.size(); ++i) {
            SCOPED_TRACE(concat(format, " ", i));
            expect_leaves(octrees[i], format, found.files[i]);
        }
    }
}

TEST_F(ExportProximity, ReportsErrors)
{
    const MeshIndex octree = testing::listed_index(sample_mesh("cube").value()).value();
    EXPECT_EQ(code_of(export_proximity(*octree.parts().lists(), path("octree.ply"))),
              ErrorCode::unsupported_format);
    EXPECT_EQ(code_of(export_proximity(*octree.parts().lists(), path("octree"))),
              ErrorCode::unsupported_format);
    for (const char* format : {"vtu", "htg"}) {
        EXPECT_EQ(code_of(export_proximity(*octree.parts().lists(),
                                           path("missing") / concat("x.", format))),
                  ErrorCode::file_not_writable);
    }
    Progress cancelled;
    cancelled.cancel();
    EXPECT_EQ(code_of(export_proximity(*octree.parts().lists(), path("x.vtu"),
                                       {.execution = {.progress = &cancelled}})),
              ErrorCode::cancelled);
    EXPECT_EQ(entries(), 0);
}

} // namespace
} // namespace proxima::export_proximity_test
