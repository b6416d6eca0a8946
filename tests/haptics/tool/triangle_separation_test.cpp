#include "haptics/tool/triangle_separation.h"

#include "geometry/triangle_distance.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

namespace proxima::testing::triangle_separation_test {
namespace {

constexpr int samples = 200;

double distance_at(const NearPair& pair, const ToolMotion& motion, double part)
{
    const RigidTransform pose = moved_by(motion.from, motion.twist, part);
    return std::sqrt(closest_points(pair.scene, pose(pair.tool)).squared_distance);
}

double free_part_of(NearPair& pair, const ToolMotion& motion, const GapLimits& limits,
                    std::size_t most_work = unlimited_work)
{
    NearPair* pairs[] = {&pair};
    ToolEffort effort = {.most = most_work};
    return free_part(pairs, motion, limits, effort);
}

/// Motions that turn by up to a radian, so that arcs matter, against distances along them.
TEST(TriangleSeparation, WhatIsProvenToStayApartDoes)
{
    const GapLimits limits = {0.02, 0.015, 0.01};
    int proven = 0;
    int stopped = 0;
    int partly = 0;
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

        NearPair* const one[] = {&pair};
        bool found = find_plane(pair, motion, limits.least, Vec3::Zero());
        if (!found) {
            set_closest_planes(one, motion.from);
            ASSERT_NEAR(plane_gap(pair, motion.from), begin, 1e-9);
            found = stays_apart(pair, motion, limits.least);
        }
        if (found) {
            ++proven;
            ASSERT_TRUE(stays_apart(pair, motion, limits.least));
            for (int i = 0; i <= samples; ++i)
                ASSERT_GE(distance_at(pair, motion, i / double{samples}), limits.least - 1e-12);
        }
        // Without time for better planes less is proven, and that is free as well.
        const double known = free_part_of(pair, motion, limits, 0);
        const double part = free_part_of(pair, motion, limits);
        EXPECT_LE(known, part);
        partly += known > 0.05 && known < part ? 1 : 0;
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
    EXPECT_GT(partly, 200);
}

/// Many pairs at once stop where the first of them does alone.
TEST(TriangleSeparation, PairsTogetherAreAsFreeAsTheLeastFree)
{
    const GapLimits limits = {0.02, 0.015, 0.01};
    for (std::uint32_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const auto vector = [&](double size) {
            std::uniform_real_distribution<double> unit(-size, size);
            const double x = unit(random);
            const double y = unit(random);
            return Vec3(x, y, unit(random));
        };
        ToolMotion motion;
        motion.from.translation = 4 * vector(1).normalized();
        motion.twist = {Vec3(vector(0.5) - 1.2 * motion.from.translation), vector(0.6)};
        motion.to = moved_by(motion.from, motion.twist, 1);
        std::vector<NearPair> pairs(21);
        std::vector<NearPair*> all;
        double alone = 1;
        for (NearPair& pair : pairs) {
            for (Vec3& corner : pair.scene.vertices) corner = vector(1);
            for (Vec3& corner : pair.tool.vertices) {
                corner = vector(1);
                pair.reach = std::max(pair.reach, corner.norm());
            }
            all.push_back(&pair);
            alone = std::min(alone, free_part_of(pair, motion, limits));
        }
        ToolEffort effort;
        const double part = free_part(all, motion, limits, effort);
        EXPECT_NEAR(part, alone, 1e-3 * limits.least);
        EXPECT_GE(effort.spent, 3U);
        EXPECT_FALSE(effort.cut_short);
        for (const NearPair& pair : pairs) {
            for (int i = 0; i <= samples; ++i) {
                ASSERT_GE(distance_at(pair, motion, part * i / samples),
                          limits.wanted * (1 - 1e-8));
            }
        }
    }
}

/// A pendulum whose tip is above the floor at both ends of its swing, and below it in between.
TEST(TriangleSeparation, ArcsBetweenTheEndsCount)
{
    NearPair pair;
    pair.scene = {{Vec3(-2, -0.95, -2), Vec3(2, -0.95, -2), Vec3(0, -0.95, 3)}};
    pair.tool = {{Vec3(0, -1, 0), Vec3(-0.1, -0.5, 0), Vec3(0.1, -0.5, 0)}};
    pair.reach = 1;
    set_normal(pair, Vec3::UnitY());
    ToolMotion motion;
    motion.from = moved_by({}, {Vec3::Zero(), Vec3(0, 0, -0.5)}, 1);
    motion.twist = {Vec3::Zero(), Vec3::UnitZ()};
    motion.to = moved_by(motion.from, motion.twist, 1);
    ASSERT_GT(plane_gap(pair, motion.from), 0.05);
    ASSERT_GT(plane_gap(pair, motion.to), 0.05);
    EXPECT_FALSE(stays_apart(pair, motion, 0.01));
    const double part = free_part_of(pair, motion, {0.02, 0.015, 0.01});
    // cos(0.5 - part) = 0.95 - 0.015 where the tip is as near as it may come.
    EXPECT_LT(part, 0.5 - std::acos(0.935) + 1e-9);
    EXPECT_GT(part, 0.5 - std::acos(0.92));
}

} // namespace
} // namespace proxima::testing::triangle_separation_test
