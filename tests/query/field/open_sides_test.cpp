#include "query/field/open_sides.h"

#include "proxima/closest_feature.h"
#include "proxima/sample_meshes.h"
#include "query/closest/signed_mesh.h"
#include "query/closest/winding_side.h"
#include "query/field/cut_meshes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

namespace proxima::open_sides_test {
namespace {

using namespace testing;

/// Balls that the surface does not enter, more of them near the middle of the mesh.
class RandomBalls {
public:
    RandomBalls(const Signed& of, std::uint32_t seed)
        : index_(of.index), box_(bounding_box(of.mesh)), random_(seed)
    {}

    [[nodiscard]] ClearBall next()
    {
        ClearBall ball;
        ball.middle = box_.center() + 0.6 * box_.extent().maxCoeff() * vector();
        ball.distance = std::sqrt(closest_feature(index_, ball.middle)->squared_distance);
        ball.radius = ball.distance * std::uniform_real_distribution<double>(0.01, 0.9)(random_);
        return ball;
    }
    /// A point of a ball, most of them near its border.
    [[nodiscard]] Vec3 point_in(const ClearBall& ball)
    {
        const double way = random_() % 3 == 0 ? 0.5 : 0.999;
        return ball.middle + way * ball.radius * vector().normalized();
    }

private:
    [[nodiscard]] Vec3 vector()
    {
        std::uniform_real_distribution<double> unit(-1, 1);
        const double x = unit(random_);
        const double y = unit(random_);
        return {x, y, unit(random_)};
    }

    const MeshIndex& index_;
    Box box_;
    std::mt19937 random_;
};

TEST(OpenSides, HoldForAllPointsOfABall)
{
    const TriangleMesh coarse = sample_mesh("icosphere:1").value();
    const TriangleMesh fine = sample_mesh("icosphere:4").value();
    const std::vector<NamedMesh> meshes = {
        {"half", cut_off(coarse, 0)},
        {"bowl", cut_off(coarse, -0.4)},
        {"inside out", inverted(cut_off(coarse, 0.5))},
        {"fine half", cut_off(fine, 0)},
        {"fine, small hole", cut_off(fine, 0.95)},
        {"two walls", joined(cut_off(coarse, 0), cut_off(coarse, 0))},
        {"torus", cut_off(sample_mesh("torus:24x12").value(), 0.1)}};
    std::size_t told = 0;
    std::size_t inside = 0;
    for (const NamedMesh& named : meshes) {
        SCOPED_TRACE(named.name);
        const Signed of(named.mesh);
        const IndexParts& index = of.index.parts();
        ASSERT_FALSE(of.arrays().is_closed());
        const OpenSides sides(index);
        RandomBalls random(of, 3);
        for (int i = 0; i < 3000; ++i) {
            const ClearBall ball = random.next();
            const std::optional<bool> side = sides.side_of(ball);
            if (!side) continue;
            ++told;
            inside += *side ? 1 : 0;
            for (int k = 0; k < 16; ++k) {
                const Vec3 p = random.point_in(ball);
                ASSERT_EQ(is_inside_by_winding(index, p), *side)
                    << "seed 3, ball " << i << " about " << ball.middle.transpose() << ", radius "
                    << ball.radius << ", at " << p.transpose();
            }
        }
    }
    EXPECT_GT(told, 4000U);
    EXPECT_GT(inside, 200U);
}

} // namespace
} // namespace proxima::open_sides_test
