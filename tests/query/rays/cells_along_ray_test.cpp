#include "proxima/cells_along_ray.h"

#include "counted_allocations.h"
#include "octree/small_meshes.h"
#include "oracles/integer_overlap.h"
#include "proxima/octree.h"
#include "query/rays/test_rays.h"

#include <gtest/gtest.h>

#include <optional>

namespace proxima::cells_along_ray_test {
namespace {

using namespace testing;
using oracle::Wide;

/// A mesh within a root whose planes are whole numbers: the cube [0, 2^depth].
Octree whole_octree(std::uint64_t seed, int depth)
{
    std::mt19937_64 random(seed);
    const auto size = static_cast<double>(1 << depth);
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < 30; ++i) {
        const auto coordinate = [&] { return static_cast<double>(random() % 1000) / 1000 * size; };
        for (int corner = 0; corner < 3; ++corner) {
            const double x = coordinate();
            const double y = coordinate();
            positions.emplace_back(x, y, coordinate());
            if (corner > 0)
                positions.back() = 0.9 * positions[std::size_t{3} * i] + 0.1 * positions.back();
        }
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const OctreeFrame root{Vec3::Zero(), Vec3::Constant(size)};
    return build_octree(mesh_of(positions, triangles),
                        {.max_depth = depth, .root = root, .classification = Classification::none})
        .value();
}

/// A ray of whole numbers.
struct WholeRay {
    std::array<std::int64_t, 3> origin;
    std::array<std::int64_t, 3> direction;
    std::int64_t t_min;
    std::int64_t t_max;

    [[nodiscard]] Ray ray() const
    {
        Ray ray;
        for (int k = 0; k < 3; ++k) {
            ray.origin[k] = static_cast<double>(origin[static_cast<std::size_t>(k)]);
            ray.direction[k] = static_cast<double>(direction[static_cast<std::size_t>(k)]);
        }
        ray.t_min = static_cast<double>(t_min);
        ray.t_max = static_cast<double>(t_max);
        return ray;
    }
};

/// numerator / denominator, the denominator positive.
struct Fraction {
    Wide numerator;
    Wide denominator;
    friend bool operator<(const Fraction& a, const Fraction& b)
    {
        return a.numerator * b.denominator < b.numerator * a.denominator;
    }
    [[nodiscard]] double value() const
    {
        return static_cast<double>(numerator) / static_cast<double>(denominator);
    }
};

struct Stretch {
    Fraction enter;
    Fraction exit;
};

/// Slabs, by fractions: where the ray is in the box, if for more than a moment. A ray along a face
/// is in the box whose lower face it is, or whose upper face is the root's.
std::optional<Stretch> stretch_in(const WholeRay& ray, const Box& box, std::int64_t root)
{
    Stretch stretch{{ray.t_min, 1}, {ray.t_max, 1}};
    for (std::size_t k = 0; k < 3; ++k) {
        const auto lower = static_cast<std::int64_t>(box.lower[static_cast<int>(k)]);
        const auto upper = static_cast<std::int64_t>(box.upper[static_cast<int>(k)]);
        const std::int64_t o = ray.origin[k];
        const std::int64_t d = ray.direction[k];
        if (d == 0) {
            if (o < lower || o > upper || (o == upper && upper != root)) return std::nullopt;
            continue;
        }
        const std::int64_t sign = d > 0 ? 1 : -1;
        const Fraction near{Wide{sign} * ((d > 0 ? lower : upper) - o), Wide{sign} * d};
        const Fraction far{Wide{sign} * ((d > 0 ? upper : lower) - o), Wide{sign} * d};
        if (stretch.enter < near) stretch.enter = near;
        if (far < stretch.exit) stretch.exit = far;
    }
    if (!(stretch.enter < stretch.exit)) return std::nullopt;
    return stretch;
}

/// A leaf that a ray passes through.
struct LeafOnRay {
    CellKey key;
    Stretch stretch;
};

/// The leaves that the ray passes through, in its order, by asking all leaves.
std::vector<LeafOnRay> leaves_on_ray(const Octree& octree, const WholeRay& ray, std::int64_t root)
{
    struct Collect {
        const Octree& octree;
        const WholeRay& ray;
        std::int64_t root;
        std::vector<LeafOnRay>& leaves;
        [[nodiscard]] bool should_enter(const Cell& /*cell*/) const { return true; }
        [[nodiscard]] Flow visit_leaf(const Cell& cell, std::span<const TriangleId> /*ids*/) const
        {
            if (const auto found = stretch_in(ray, octree.box(cell), root))
                leaves.push_back({cell.key, *found});
            return Flow::proceed;
        }
    };
    std::vector<LeafOnRay> leaves;
    traverse(octree, Collect{octree, ray, root, leaves});
    std::ranges::sort(leaves, [](const LeafOnRay& a, const LeafOnRay& b) {
        return a.stretch.enter < b.stretch.enter;
    });
    return leaves;
}

/// Number i of a series of rays: short and long, slow and fast, from in and around the root.
WholeRay nth_whole_ray(int i, std::int64_t root, std::mt19937_64& random)
{
    const auto whole = [&](std::int64_t limit) {
        return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * limit + 1)) -
               limit;
    };
    WholeRay ray{};
    const std::int64_t reach = i % 3 == 0 ? 3 : i % 3 == 1 ? 40 : 1'000'000;
    for (std::size_t k = 0; k < 3; ++k) {
        ray.origin[k] = root / 2 + whole(i % 2 == 0 ? root : 3 * root);
        ray.direction[k] = i % 7 == 0 ? whole(reach) : root / 2 + whole(root / 2) - ray.origin[k];
    }
    ray.t_min = i % 4 == 0 ? 1 : -100;
    ray.t_max = i % 5 == 0 ? 2 : 1000;
    return ray;
}

TEST(CellsAlongRay, AgreeWithSlabTestsOfAllLeaves)
{
    constexpr int depth = 5;
    constexpr std::int64_t root = 1 << depth;
    std::size_t cells = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const Octree octree = whole_octree(seed, depth);
        std::mt19937_64 random(seed);
        for (int i = 0; i < 300; ++i) {
            const WholeRay whole_ray = nth_whole_ray(i, root, random);
            if (whole_ray.direction == std::array<std::int64_t, 3>{}) continue;
            const Ray ray = whole_ray.ray();
            const std::vector<LeafOnRay> truth = leaves_on_ray(octree, whole_ray, root);
            const std::vector<CellOnRay> found = cells_along_ray(octree, ray);
            ASSERT_EQ(found.size(), truth.size()) << "ray " << i;
            double chords = 0;
            for (std::size_t c = 0; c < found.size(); ++c) {
                ASSERT_EQ(found[c].cell.key, truth[c].key) << "ray " << i << " cell " << c;
                EXPECT_NEAR(found[c].enter, truth[c].stretch.enter.value(), 1e-12);
                EXPECT_NEAR(found[c].exit, truth[c].stretch.exit.value(), 1e-12);
                if (c > 0) {
                    EXPECT_EQ(found[c].enter, found[c - 1].exit);
                }
                EXPECT_GE(found[c].penetration, 0);
                EXPECT_LE(found[c].penetration, 1);
                chords += found[c].chord;
            }
            const auto whole_root = stretch_in(whole_ray, octree.box(octree.root()), root);
            ASSERT_EQ(whole_root.has_value(), !found.empty());
            if (whole_root) {
                const double chord =
                    (whole_root->exit.value() - whole_root->enter.value()) * ray.direction.norm();
                EXPECT_NEAR(chords, chord, 1e-12 * chord);
            }
            cells += found.size();
        }
    }
    EXPECT_GT(cells, 3000U);
}

TEST(CellsAlongRay, JoinWithoutGapsForRaysOfAllKinds)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 40, 30);
    const TriangleMesh placed =
        moved(torus, [](const Vec3& p) { return Vec3(1e-3 * p + Vec3(10.1, -20.2, 30.3)); });
    const Octree octree =
        build_octree(placed, {.max_depth = 7, .classification = Classification::none}).value();
    RayGenerator generate(placed, 5);
    std::size_t cells = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Ray ray = generate();
        double last = -HUGE_VAL;
        CellKey previous{};
        const std::size_t before = allocation_count();
        std::size_t wrong = 0;
        cells_along_ray(octree, ray, [&](const CellOnRay& at) {
            if (last != -HUGE_VAL && at.enter != last) ++wrong;
            if (!(at.enter <= at.exit) || at.cell.key == previous) ++wrong;
            const Box box = octree.box(at.cell);
            const Vec3 middle = ray.at(0.5 * at.enter + 0.5 * at.exit);
            const double slack = 1e-13 * (middle.norm() + (middle - ray.origin).norm());
            if ((box.lower - middle).maxCoeff() > slack || (middle - box.upper).maxCoeff() > slack)
                ++wrong;
            last = at.exit;
            previous = at.cell.key;
            ++cells;
            return Flow::proceed;
        });
        ASSERT_EQ(wrong, 0U) << "ray " << i;
        ASSERT_EQ(allocation_count(), before);
    }
    EXPECT_GT(cells, 100'000U);
}

TEST(CellsAlongRay, StopOnRequest)
{
    const Octree octree = whole_octree(1, 4);
    const Ray ray{Vec3(-1, 7.3, 8.2), Vec3(1, 0.01, 0.02)};
    const std::vector<CellOnRay> all = cells_along_ray(octree, ray);
    ASSERT_GT(all.size(), 3U);
    std::size_t seen = 0;
    cells_along_ray(octree, ray,
                    [&](const CellOnRay&) { return ++seen == 3 ? Flow::stop : Flow::proceed; });
    EXPECT_EQ(seen, 3U);
    EXPECT_TRUE(cells_along_ray(octree, {Vec3::Zero(), Vec3::Zero()}).empty());
    EXPECT_TRUE(cells_along_ray(octree, {Vec3(1, 1, 1), Vec3::UnitX(), 2, 2}).empty());
}

TEST(Penetration, IsOneThroughTheCentreAndZeroAlongTheBorder)
{
    const Box cube{Vec3::Constant(-1), Vec3::Constant(1)};
    const auto weight = [&](const Vec3& o, const Vec3& d) { return penetration(cube, {o, d}); };
    EXPECT_DOUBLE_EQ(weight({-5, 0, 0}, {1, 0, 0}), 1);
    EXPECT_DOUBLE_EQ(weight({-5, 0.5, 0}, {1, 0, 0}), 0.5);
    EXPECT_DOUBLE_EQ(weight({-5, 1, 0}, {3, 0, 0}), 0);
    EXPECT_DOUBLE_EQ(weight({-5, 2, 0}, {1, 0, 0}), 0);
    EXPECT_DOUBLE_EQ(weight({5, 5, 5}, {-2, -2, -2}), 1);
    const Vec3 by(7, -3, 2);
    EXPECT_DOUBLE_EQ(
        penetration({cube.lower + by, cube.upper + by}, {Vec3(-5, 0.5, 0) + by, Vec3::UnitX()}),
        0.5);
    // Along (1, 1, 1) the prism's sides are 2 / sqrt 2 from its axis; along (1, 1, 0) those that
    // stand on the diagonal are as far, top and bottom 1.
    EXPECT_NEAR(weight(Vec3(1, -1, 0) * 0.5, {1, 1, 1}), 1 - 1 / 2.0, 1e-15);
    EXPECT_NEAR(weight({-3, -3, 0.25}, {1, 1, 0}), 0.75, 1e-15);
    // By hand for one slanted ray: the distance from the silhouette's sides in a projection.
    const Ray slanted{Vec3(0.3, -0.2, 0.1), Vec3(1, 2, 3)};
    double least = HUGE_VAL;
    double most = HUGE_VAL;
    for (int k = 0; k < 3; ++k) {
        const Vec3 side = Vec3::Unit(k).cross(slanted.direction).normalized();
        double reach = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 p((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                         (corner & 4) != 0 ? 1 : -1);
            reach = std::max(reach, side.dot(p));
        }
        least = std::min(least, reach - std::abs(side.dot(slanted.origin)));
        most = std::min(most, reach);
    }
    EXPECT_NEAR(penetration(cube, slanted), least / most, 1e-14);
}

} // namespace
} // namespace proxima::cells_along_ray_test
