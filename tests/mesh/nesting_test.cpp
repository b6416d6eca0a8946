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

} // namespace
} // namespace proxima::nesting_test
