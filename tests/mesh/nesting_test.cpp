#include "mesh/nesting.h"

#include "mesh/mesh_drafts.h"
#include "mesh/random_soups.h"

#include <gtest/gtest.h>
#include <random>

namespace proxima::nesting_test {
namespace {

/// Cubes on a small grid of whole numbers: their planes, edges and corners meet all the time. A
/// cube has the point moved by hairs along x, y and z inside if it holds it half open.
TEST(OddNesting, AgreesWithIntervalsOfCubes)
{
    std::uint64_t inside = 0;
    for (std::uint32_t seed = 0; seed < 1500; ++seed) {
        SCOPED_TRACE(seed);
        std::mt19937 random(seed);
        Draft draft;
        std::vector<Box> boxes;
        std::vector<std::uint32_t> surface_of;
        std::vector<SurfaceSample> samples;
        const std::uint32_t cubes = below(random, 12);
        for (std::uint32_t i = 0; i < cubes; ++i) {
            const Vec3 lower(below(random, 6), below(random, 6), below(random, 6));
            const double half = 0.5 * (1 + below(random, 4));
            draft.add(make_cube(), lower + Vec3::Constant(half), half);
            boxes.emplace_back();
            boxes.back().extend(lower);
            boxes.back().extend(lower + Vec3::Constant(2 * half));
            surface_of.resize(12 * boxes.size(), below(random, 8) == 0 ? no_surface : i);
            samples.push_back({lower, i});
        }
        const auto odd = odd_nesting(draft.mesh(), surface_of, samples, {1}, nullptr);
        ASSERT_EQ(odd.size(), cubes);
        for (std::uint32_t i = 0; i < cubes; ++i) {
            std::uint8_t expected = 0;
            for (std::uint32_t other = 0; other < cubes; ++other) {
                if (other == i || surface_of[std::size_t{12} * other] == no_surface) continue;
                const Vec3& p = samples[i].position;
                const bool holds = (boxes[other].lower.array() <= p.array()).all() &&
                                   (p.array() < boxes[other].upper.array()).all();
                if (holds) expected ^= 1U;
            }
            EXPECT_EQ(odd[i], expected) << "cube " << i;
            inside += expected;
        }
        EXPECT_EQ(odd_nesting(draft.mesh(), surface_of, samples, {3}, nullptr), odd);
    }
    EXPECT_GT(inside, 500U);
}

TEST(OddNesting, MovesPointsOfSlantedFacesAlongXFirst)
{
    // A solid below the plane z = x: a point of that face is inside once it moves along x.
    Draft draft;
    draft.positions = {Vec3(0, 0, 0), Vec3(4, 0, 4), Vec3(2, 4, 2), Vec3(4, 1, 0)};
    draft.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
    const std::vector<std::uint32_t> surface_of(4, 0);
    const std::vector<SurfaceSample> samples = {{Vec3(2, 1, 2), 1}};
    EXPECT_EQ(odd_nesting(draft.mesh(), surface_of, samples, {1}, nullptr),
              std::vector<std::uint8_t>{1});
    for (TriangleCorners& corners : draft.triangles) std::swap(corners[0], corners[1]);
    for (Vec3& p : draft.positions) std::swap(p.x(), p.z()); // the solid above z = x
    EXPECT_EQ(odd_nesting(draft.mesh(), surface_of, samples, {1}, nullptr),
              std::vector<std::uint8_t>{0});
}

TEST(NestedSurfaces, HaveACornerOfTheirOwn)
{
    Draft draft = cube_draft();
    draft.triangles.insert(draft.triangles.end(), {{1, 2, 4}, {1, 7, 2}, {1, 4, 7}, {2, 7, 4}});
    std::vector<std::uint32_t> surface_of(16, 1);
    std::fill_n(surface_of.begin(), 12, 0U);
    EXPECT_EQ(nested_surfaces(draft.mesh(), surface_of, 2, {1}, nullptr),
              (std::vector<std::uint8_t>{0, 0}));
}

} // namespace
} // namespace proxima::nesting_test
