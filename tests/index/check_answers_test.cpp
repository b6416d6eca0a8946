// An index that is sound but answers wrongly is found by comparing with all triangles.
#include "query/closest/check_answers.h"

#include "code_of.h"
#include "index/damaged_index.h"
#include "lab/query_sets.h"

#include <bit>

namespace proxima::check_answers_test {
namespace {

using testing::EditableIndex;

TEST(CheckAnswers, FindsALeafThatOmitsATriangle)
{
    const TriangleMesh mesh = sample_mesh("torus:24x36").value();
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = testing::listed_index(mesh).value();
    std::vector<Vec3> points;
    for (const QuerySet& set : query_sets(mesh, 500, 3))
        points.insert(points.end(), set.points.begin(), set.points.end());
    const auto message = [&](const MeshIndex& of, int threads) {
        const Status status =
            check_answers(of, mesh, topology, points, {.execution = {.threads = {threads}}});
        return status ? std::string() : describe(status.error());
    };
    EXPECT_EQ(message(index, 1), "");
    // In every leaf of one block the last of its triangles is forgotten: the structure is sound.
    EditableIndex edited(with_signs(index).value());
    for (std::vector<std::uint64_t>* const words : {&edited.table, &edited.nodes}) {
        for (std::uint64_t& word : *words) {
            const std::uint32_t mask = proximity_word::mask(word);
            if (proximity_word::is_leaf(word) && proximity_word::is_block(word) &&
                std::popcount(mask) > 1)
                word = proximity_word::leaf(proximity_word::position(word), mask & (mask - 1));
        }
    }
    const MeshIndex broken = edited.adopted();
    const std::string found = message(broken, 1);
    EXPECT_NE(found.find("the index answers"), std::string::npos) << found;
    EXPECT_NE(found.find("the closest is"), std::string::npos) << found;
    EXPECT_EQ(message(broken, 3), found);
}

TEST(CheckAnswers, CanBeCancelled)
{
    const TriangleMesh mesh = sample_mesh("cube").value();
    const Topology topology = build_topology(mesh).value();
    const MeshIndex index = testing::listed_index(mesh).value();
    Progress progress;
    progress.cancel();
    const std::vector<Vec3> points(10, Vec3::Ones());
    const Status status =
        check_answers(index, mesh, topology, points, {.execution = {.progress = &progress}});
    ASSERT_FALSE(status);
    EXPECT_EQ(code_of(status), ErrorCode::cancelled);
}

} // namespace
} // namespace proxima::check_answers_test
