// The triangles nearest to a point, in order.
#include "geometry/closest_point.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"
#include "proxima/sample_meshes.h"
#include "query/neighbourhood/random_balls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>
#include <span>
#include <vector>

namespace proxima::nearest_triangles_test {
namespace {

using namespace testing;

TEST(NearestTriangles, AreTheFirstOfAllByDistanceAndId)
{
    std::size_t ties = 0;
    for_balls(25, 5, [&](const auto& mesh, const auto&, const auto& index, const Ball& ball) {
        std::vector<NearTriangle> all(mesh.triangle_count());
        const Neighbourhood every = collect_nearest(index, ball.p, all);
        ASSERT_EQ(every.written, all.size());
        EXPECT_TRUE(every.complete);
        EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
        std::set<TriangleId> ids;
        for (const NearTriangle& one : all) {
            ids.insert(one.triangle);
            const Vec3 closest = closest_point(mesh.triangle(one.triangle), ball.p).point;
            EXPECT_NEAR(std::sqrt(one.squared_distance), (closest - ball.p).norm(), ball.rounding);
        }
        EXPECT_EQ(ids.size(), all.size());
        EXPECT_EQ(all[0].squared_distance, closest_feature(index, ball.p)->squared_distance);
        for (const std::size_t count :
             {std::size_t{1}, std::size_t{2}, std::size_t{7}, all.size() - 1, all.size() + 3}) {
            std::vector<NearTriangle> some(count);
            const Neighbourhood found = collect_nearest(index, ball.p, some);
            ASSERT_EQ(found.written, std::min(count, all.size()));
            EXPECT_EQ(found.complete, count >= all.size());
            EXPECT_TRUE(std::equal(all.begin(), all.begin() + static_cast<long>(found.written),
                                   some.begin()));
            if (0 < count && count < all.size())
                ties += all[count - 1].squared_distance == all[count].squared_distance ? 1 : 0;
            // With a radius.
            const Neighbourhood within = collect_nearest(index, ball.p, some, ball.radius);
            std::vector<TriangleId> patch(all.size());
            patch.resize(collect_triangles(index, ball.p, ball.radius, patch).written);
            ASSERT_EQ(within.written, std::min(count, patch.size()));
            for (std::size_t i = 0; i < within.written; ++i) EXPECT_EQ(some[i], all[i]);
        }
    });
    EXPECT_GT(ties, 20U) << "the id decides some";
}

TEST(NearestTriangles, AreVisitedInOrderUntilTheVisitorStops)
{
    std::size_t ties = 0;
    for_balls(5, 8, [&](const auto& mesh, const auto&, const auto& index, const Ball& ball) {
        std::vector<NearTriangle> all;
        visit_triangles(index, ball.p, HUGE_VAL, [&](TriangleId id, double squared) {
            all.push_back({squared, id});
            return Flow::proceed;
        });
        std::ranges::sort(all, [](const auto& a, const auto& b) { return a < b; });
        ASSERT_EQ(all.size(), mesh.triangle_count());
        for (const std::size_t size :
             {std::size_t{1}, std::size_t{3}, all.size(), all.size() + 1}) {
            for (const double radius : {HUGE_VAL, ball.radius}) {
                std::vector<NearTriangle> batch(size);
                std::vector<NearTriangle> visited;
                std::size_t most = all.size();
                const auto visitor = [&](TriangleId id, double squared) {
                    visited.push_back({squared, id});
                    return visited.size() < most ? Flow::proceed : Flow::stop;
                };
                visit_nearest(index, ball.p, batch, visitor, radius);
                std::vector<NearTriangle> wanted = all;
                if (radius == ball.radius) {
                    std::vector<TriangleId> patch(all.size());
                    wanted.resize(collect_triangles(index, ball.p, radius, patch).written);
                }
                EXPECT_EQ(visited, wanted) << "batches of " << size;
                if (wanted.size() < 2) continue;
                most = wanted.size() / 2;
                visited.clear();
                visit_nearest(index, ball.p, batch, visitor, radius);
                wanted.resize(most);
                EXPECT_EQ(visited, wanted) << "batches of " << size;
            }
        }
        for (std::size_t i = 1; i < all.size(); ++i)
            ties += all[i - 1].squared_distance == all[i].squared_distance ? 1 : 0;
    });
    EXPECT_GT(ties, 20U) << "batches end between some";
}

TEST(NearestTriangles, AreTheFirstOnMeshesFarFromTheOrigin)
{
    // There, squared distances of triangles that p is all but on are what coordinates round by.
    const TriangleMesh torus = sample_mesh("torus:24x16").value();
    std::mt19937_64 random(61);
    std::uniform_real_distribution<double> part(0, 0.5);
    for (const double far : {1e6, 1e9, 1e11}) {
        std::vector<Vec3> positions;
        for (const Vec3& p : torus.positions()) positions.emplace_back(p + far * Vec3(1, -0.3, 0));
        const TriangleMesh mesh =
            make_triangle_mesh(positions, {torus.triangles().begin(), torus.triangles().end()})
                .value();
        const MeshIndex index = build_mesh_index(mesh).value();
        for (std::uint32_t id = 0; id < mesh.triangle_count(); ++id) {
            const Triangle t = mesh.triangle(TriangleId{id});
            Vec3 p = id % 2 == 0
                         ? t[0]
                         : Vec3(t[0] + part(random) * (t[1] - t[0]) + part(random) * (t[2] - t[0]));
            p.z() += 2e-8 * (part(random) - 0.5);
            std::vector<NearTriangle> all;
            visit_triangles(index, p, HUGE_VAL, [&](TriangleId at, double squared) {
                all.push_back({squared, at});
                return Flow::proceed;
            });
            std::ranges::sort(all, [](const auto& a, const auto& b) { return a < b; });
            for (const std::size_t count : {1U, 2U, 5U}) {
                std::vector<NearTriangle> some(count);
                ASSERT_EQ(collect_nearest(index, p, some).written, count);
                EXPECT_TRUE(std::ranges::equal(some, std::span(all).first(count)))
                    << far << ' ' << id;
            }
        }
    }
}

TEST(NearestTriangles, AcceptOddQuestions)
{
    const MeshIndex index = build_mesh_index(cube_mesh(Vec3::Zero(), 1.0)).value();
    std::array<NearTriangle, 3> three{};
    const auto written = [&](const Vec3& p, double radius) {
        return collect_nearest(index, p, three, radius).written;
    };
    constexpr double infinite = std::numeric_limits<double>::infinity();
    EXPECT_EQ(written(Vec3::Zero(), 0.999), 0U);
    EXPECT_EQ(written(Vec3::Zero(), 1), 3U);
    EXPECT_EQ(written(Vec3::Zero(), NAN), 0U);
    EXPECT_EQ(written(Vec3::Zero(), -1), 0U);
    EXPECT_EQ(written(Vec3(NAN, 0, 0), infinite), 0U);
    EXPECT_EQ(written(Vec3(1e300, 0, 0), infinite), 3U);
    const auto visited = [&](const Vec3& p, double radius) {
        std::size_t count = 0;
        const auto visitor = [&](TriangleId, double) {
            ++count;
            return Flow::proceed;
        };
        visit_nearest(index, p, three, visitor, radius);
        return count;
    };
    EXPECT_EQ(visited(Vec3::Zero(), 0.999), 0U);
    EXPECT_EQ(visited(Vec3::Zero(), 1), 12U);
    EXPECT_EQ(visited(Vec3::Zero(), NAN), 0U);
    EXPECT_EQ(visited(Vec3::Zero(), -1), 0U);
    EXPECT_EQ(visited(Vec3(NAN, 0, 0), infinite), 0U);
    EXPECT_EQ(visited(Vec3(1e300, 0, 0), infinite), 12U);
    EXPECT_FALSE(collect_nearest(index, Vec3::Zero(), {}).complete);
    EXPECT_TRUE(collect_nearest(index, Vec3::Zero(), {}, 0.5).complete);
    // Where squares of the mesh's own unit vanish or overflow.
    for (const double size : {1e-200, 1e160}) {
        const TriangleMesh ball = moved(sample_mesh("icosphere:3").value(),
                                        [&](const Vec3& p) { return Vec3(size * p); });
        const MeshIndex whole = build_mesh_index(ball).value();
        const MeshIndex plain = build_mesh_index(sample_mesh("icosphere:3").value()).value();
        std::array<NearTriangle, 20> some{};
        std::array<NearTriangle, 20> same{};
        const Vec3 p(0.7, 0.2, 0.4);
        ASSERT_EQ(collect_nearest(whole, size * p, some).written, 20U);
        ASSERT_EQ(collect_nearest(plain, p, same).written, 20U);
        std::set<TriangleId> ids;
        std::set<TriangleId> wanted;
        for (std::size_t i = 0; i < 20; ++i) {
            ids.insert(some[i].triangle);
            wanted.insert(same[i].triangle);
        }
        EXPECT_EQ(ids, wanted) << size;
        std::vector<TriangleId> within(ball.triangle_count());
        const double radius = 0.4;
        EXPECT_EQ(collect_triangles(whole, size * p, size * radius, within).written,
                  collect_triangles(plain, p, radius, within).written);
    }
}

} // namespace
} // namespace proxima::nearest_triangles_test
