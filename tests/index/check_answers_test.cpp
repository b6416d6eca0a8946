// An index that is sound but answers wrongly is found by comparing with all triangles.
#include "query/closest/check_answers.h"

#include "code_of.h"
#include "index/damaged_index.h"
#include "lab/query_sets.h"

#include <bit>
#include <cmath>

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

TEST(CheckAnswers, KnowsRoundingFromWrongAnswers)
{
    const TriangleMesh mesh = sample_mesh("icosphere:2").value();
    const Topology topology = build_topology(mesh).value();
    const auto is_sound = [&](double grown, double distance, double scale) {
        const auto resized = [](double size) {
            return [=](const Vec3& p) -> Vec3 { return size * p; };
        };
        const MeshIndex own = build_mesh_index(testing::moved(mesh, resized(scale))).value();
        const TriangleMesh other = testing::moved(mesh, resized(scale * grown));
        std::vector<Vec3> points;
        for (int i = 0; i < 100; ++i)
            points.push_back(scale * distance * Vec3(std::sin(i), std::cos(i), std::sin(3 * i)));
        const Status status = check_answers(own, other, topology, points, {});
        return status.has_value();
    };
    for (const double distance : {0.5, 2.0, 1e7}) {
        EXPECT_TRUE(is_sound(1, distance, 1)) << distance;
        // Squared distances are infinite, or 0.
        EXPECT_TRUE(is_sound(1, distance, 1e160)) << distance;
        EXPECT_TRUE(is_sound(1, distance, 1e-160)) << distance;
        EXPECT_TRUE(is_sound(1 + 1e-14, distance, 1)) << distance;
    }
    EXPECT_TRUE(is_sound(1 + 1e-8, 1e7, 1)); // below the digits of such distances
    EXPECT_FALSE(is_sound(1 + 1e-9, 0.5, 1));
    EXPECT_FALSE(is_sound(1 + 1e-9, 2, 1));
    EXPECT_FALSE(is_sound(1 + 1e-9, 2, 1e-6));
    EXPECT_FALSE(is_sound(1 + 1e-9, 2, 1e6));
    EXPECT_FALSE(is_sound(1 + 1e-9, 2, 1e160));
    EXPECT_FALSE(is_sound(1 + 1e-9, 2, 1e-160));
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
