#include "haptics/tool/triangle_separation.h"

#include "geometry/triangle_distance.h"

#include <gtest/gtest.h>
#include <random>
#include <string>

namespace proxima::testing {
namespace {

constexpr int samples = 200;

double distance_at(const NearPair& pair, const ToolMotion& motion, double part)
{
    const RigidTransform pose = moved_by(motion.from, motion.twist, part);
    return std::sqrt(closest_points(pair.scene, pose(pair.tool)).squared_distance);
}

/// Motions that turn by up to a radian, so that arcs matter, against distances along them.
TEST(TriangleSeparation, WhatIsProvenToStayApartDoes)
{
    const GapLimits limits = {0.02, 0.015, 0.01};
    int proven = 0;
    int stopped = 0;
    for (std::uint32_t seed = 1; seed <= 1500; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const auto vector = [&](double size) {
            std::uniform_real_distribution<double> unit(-size, size);
            const double x = unit(random);
            const double y = unit(random);
            return Vec3(x, y, unit(random));
        };
        NearPair pair;
        for (Vec3& corner : pair.scene.vertices) corner = vector(1);
        for (Vec3& corner : pair.tool.vertices) {
            corner = vector(1);
            pair.reach = std::max(pair.reach, corner.norm());
        }
        ToolMotion motion;
        motion.from.translation = 3 * vector(1).normalized();
        motion.twist = {Vec3(vector(0.5) - 1.2 * motion.from.translation), vector(0.6)};
        motion.to = moved_by(motion.from, motion.twist, 1);
        const double begin = distance_at(pair, motion, 0);
        if (!(begin > 0)) continue;

        Vec3 last = Vec3::Zero();
        if (find_plane(pair, motion, limits.least, last)) {
            ++proven;
            ASSERT_TRUE(stays_apart(pair, motion, limits.least));
            for (int i = 0; i <= samples; ++i)
                ASSERT_GE(distance_at(pair, motion, i / double{samples}), limits.least - 1e-12);
        }
        const double part = free_part(pair, motion, limits, 1);
        const double least = begin >= limits.near ? limits.wanted : std::min(limits.least, begin);
        for (int i = 0; i <= samples; ++i)
            ASSERT_GE(distance_at(pair, motion, part * i / samples), least * (1 - 1e-8));
        if (part < 1) {
            ++stopped;
            EXPECT_LT(distance_at(pair, motion, part), 2 * limits.wanted) << part;
        }
    }
    EXPECT_GT(proven, 200);
    EXPECT_GT(stopped, 200);
}

} // namespace
} // namespace proxima::testing
