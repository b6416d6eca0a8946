// Where a surface touches itself, of which signs by pseudonormals know.
#include "geometry/exact_predicates.h"
#include "geometry/triangle_contact.h"
#include "index/signs/surface_sides.h"
#include "index/test_meshes.h"
#include "proxima/mesh_index.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace proxima::self_contacts_test {
namespace {

using namespace testing;

/// All pairs: a triangle meets another one where they share more than their common corners say, by
/// triangles_meet on those without common ids, by area moved off the common corner on others.
TEST(SelfContacts, AgreeWithAllPairs)
{
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE(seed);
        const TriangleMesh mesh = seed % 2 == 0 ? nasty_mesh(seed) : grid_mesh(seed);
        const MeshIndex index = build_mesh_index(mesh).value();
        const auto contacts = find_self_contacts(index, mesh).value();
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            const Triangle a = mesh.triangle(TriangleId{i});
            bool apart_ids_meet = false;
            bool all_ids_differ = true;
            for (std::uint32_t k = 0; k < mesh.triangle_count() && !is_degenerate(a); ++k) {
                const Triangle b = mesh.triangle(TriangleId{k});
                if (k == i || is_degenerate(b)) continue;
                const auto& ids = mesh.triangles()[k];
                const bool shares = std::ranges::any_of(mesh.triangles()[i], [&](std::uint32_t id) {
                    return std::ranges::find(ids, id) != ids.end();
                });
                all_ids_differ = all_ids_differ && !shares;
                if (!shares) apart_ids_meet = apart_ids_meet || triangles_meet(a, b);
            }
            if (apart_ids_meet) {
                EXPECT_EQ(contacts[i], 1);
            }
            if (all_ids_differ) {
                EXPECT_EQ(contacts[i], apart_ids_meet ? 1 : 0);
            }
        }
    }
}

TEST(SelfContacts, OfNeighboursAreFoldsAndCrossings)
{
    const auto contacts = [](const std::vector<Vec3>& positions,
                             const std::vector<TriangleCorners>& triangles) {
        const TriangleMesh mesh = mesh_of(positions, triangles);
        return find_self_contacts(build_mesh_index(mesh).value(), mesh).value();
    };
    using Flags = std::vector<std::uint8_t>;
    const std::vector<Vec3> quad = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(4, 4, 0), Vec3(0, 4, 0),
                                    Vec3(3, 1, 0)};
    EXPECT_EQ(contacts(quad, {{0, 1, 2}, {0, 2, 3}}), (Flags{0, 0})); // flat
    EXPECT_EQ(contacts(quad, {{0, 1, 2}, {0, 2, 4}}), (Flags{1, 1})); // folded
    EXPECT_EQ(contacts(quad, {{0, 1, 2}, {2, 1, 0}}), (Flags{1, 1})); // front and back
    EXPECT_EQ(contacts(quad, {{0, 1, 2}, {0, 3, 4}}), (Flags{1, 1})); // overlap at 0
    EXPECT_EQ(contacts(quad, {{0, 1, 4}, {0, 2, 3}}), (Flags{0, 0})); // only 0 is common
    const std::vector<Vec3> fan = {Vec3(0, 0, 0), Vec3(4, 0, 0),   Vec3(0, 4, 0),   Vec3(3, 3, -1),
                                   Vec3(3, 3, 1), Vec3(-3, -3, 1), Vec3(-3, -2, -1)};
    EXPECT_EQ(contacts(fan, {{0, 1, 2}, {0, 3, 4}}), (Flags{1, 1})); // passes through from 0
    EXPECT_EQ(contacts(fan, {{0, 1, 2}, {0, 5, 6}}), (Flags{0, 0})); // away from it

    // Too many to look at: a fan of far more needles than are looked at, none of which meet.
    std::vector<Vec3> rim = {Vec3(0, 0, 1)};
    std::vector<TriangleCorners> needles;
    for (std::uint32_t i = 0; i < 4200; ++i) {
        rim.emplace_back(std::cos(1e-3 * i), std::sin(1e-3 * i), 0);
        if (i > 0) needles.push_back({0, i, i + 1});
    }
    EXPECT_EQ(std::ranges::count(contacts(rim, needles), 1), 4199);
}

} // namespace
} // namespace proxima::self_contacts_test
