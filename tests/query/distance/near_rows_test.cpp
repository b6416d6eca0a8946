#include "query/distance/near_rows.h"

#include "geometry/triangle_distance.h"
#include "octree/small_meshes.h"
#include "proxima/sample_meshes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace proxima::testing::near_rows_test {
namespace {

/// Against all pairs: every near one is there once, with the way across, and none that is farther
/// but for rounding.
TEST(NearRows, AreAllPairsWithinTheDistance)
{
    const TriangleMesh first = *sample_mesh("torus:16x8");
    const TriangleMesh second = *sample_mesh("sphere:12x12");
    const MeshIndex a = build_mesh_index(first).value();
    const MeshIndex b = with_slabs(build_mesh_index(second).value()).value();
    constexpr double rounding = 1e-5; // of floats
    std::size_t found = 0;
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const auto unit = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
        RigidTransform pose;
        pose.rotation =
            Eigen::Quaterniond(unit(), unit(), unit(), unit()).normalized().toRotationMatrix();
        pose.translation = 2 * Vec3(unit(), unit(), unit());
        const double distance = 0.01 * (1 << seed % 6);
        std::vector<NearRows> rows(a.triangle_count() * std::size_t{b.triangle_count()});
        const NearRowsAnswer answer = near_rows(a, b, pose, distance, rows);
        ASSERT_TRUE(answer.complete);
        std::set<std::pair<std::uint32_t, std::uint32_t>> listed;
        for (std::size_t i = 0; i < answer.count; ++i) {
            EXPECT_TRUE(listed.emplace(rows[i].a, rows[i].b).second);
            const ClosestTrianglePoints nearest = closest_points(
                first.triangle(a.ids()[rows[i].a]), pose(second.triangle(b.ids()[rows[i].b])));
            const Vec3 across = nearest.second.point - nearest.first.point;
            EXPECT_LT((across - across.norm() * rows[i].across.normalized()).norm(), rounding);
        }
        for (std::uint32_t i = 0; i < a.triangle_count(); ++i) {
            for (std::uint32_t k = 0; k < b.triangle_count(); ++k) {
                const double apart = std::sqrt(
                    closest_points(first.triangle(a.ids()[i]), pose(second.triangle(b.ids()[k])))
                        .squared_distance);
                const bool is_listed = listed.contains({i, k});
                ASSERT_TRUE(is_listed || apart > distance) << apart;
                ASSERT_TRUE(!is_listed || apart < distance + rounding) << apart;
            }
        }
        found += answer.count;
        if (answer.count > 1) {
            const NearRowsAnswer part =
                near_rows(a, b, pose, distance, std::span(rows).first(answer.count - 1));
            EXPECT_FALSE(part.complete);
            EXPECT_EQ(part.count, answer.count - 1);
        }
    }
    EXPECT_GT(found, 1000U);
}

} // namespace
} // namespace proxima::testing::near_rows_test
