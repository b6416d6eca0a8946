#include "haptics/surface/near_groups.h"

#include "base/simd.h"
#include "geometry/closest_point.h"
#include "haptics/patch_triangles.h"
#include "haptics/proxy/contact_cache.h"
#include "haptics/surface/contact_patch.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "index/listed_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace proxima {
namespace {

using testing::TouchMesh;

constexpr std::size_t block = 64; // triangles of eight groups of eight

/// Copies of one triangle, then of another one farther from the origin.
TriangleMesh two_heaps(std::uint32_t near_copies, std::uint32_t far_copies)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (const double z : {1.0, 2.0}) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        positions.emplace_back(-0.25, -0.25, z);
        positions.emplace_back(0.5, -0.25, z);
        positions.emplace_back(-0.25, 0.5, z);
        const std::uint32_t copies = z < 1.5 ? near_copies : far_copies;
        triangles.insert(triangles.end(), copies, TriangleCorners{first, first + 1, first + 2});
    }
    return testing::mesh_of(std::move(positions), std::move(triangles));
}

/// Fans of slivers as long as all of it: boxes lie about each other.
TriangleMesh long_slivers(std::uint32_t count)
{
    std::vector<Vec3> positions = {Vec3::Zero()};
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double turn = 2.4 * i;
        const double up = 2.0 * i / count - 1;
        const Vec3 end(std::cos(turn), std::sin(turn), up);
        positions.emplace_back(end);
        positions.emplace_back(end + Vec3(1e-7, 2e-7, 1e-7));
        triangles.push_back({0, 2 * i + 1, 2 * i + 2});
    }
    return testing::mesh_of(std::move(positions), std::move(triangles));
}

std::vector<TouchMesh> meshes()
{
    std::vector<TouchMesh> all = testing::touch_meshes();
    all.push_back({"fine torus", *sample_mesh("torus:60x30")});
    all.push_back({"many", testing::triangle_soup(11, 1500)});
    all.push_back({"heaps", two_heaps(700, 1300)});
    all.push_back({"slivers", long_slivers(900)});
    all.push_back({"far torus", testing::moved(*sample_mesh("torus:40x20"), [](const Vec3& p) {
                       return Vec3(p + Vec3(-1e6, 1e6, 3e5));
                   })});
    return all;
}

std::size_t blocks_within(const std::vector<double>& gaps, double distance)
{
    return static_cast<std::size_t>(
        std::ranges::count_if(gaps, [&](double gap) { return gap <= distance; }));
}

/// A mesh, its index's surface, and how far every triangle and every block's box are from a place.
/// Of the index only the tree of boxes counts.
class Everything {
public:
    explicit Everything(const TriangleMesh& mesh)
        : mesh_(mesh), index_(*testing::listed_index(mesh, {.max_depth = 1})), surface_(index_)
    {
        std::vector<std::uint32_t> ranks(mesh.triangle_count());
        std::iota(ranks.begin(), ranks.end(), 0U);
        std::vector<ContactTriangle> triangles(ranks.size());
        surface_.read_triangles(ranks, triangles);
        for (std::size_t rank = 0; rank < triangles.size(); ++rank) {
            if (rank % block == 0) boxes_.emplace_back();
            for (const Vec3& corner : triangles[rank].corners.vertices)
                boxes_.back().extend(corner);
        }
    }
    [[nodiscard]] const IndexContactSurface& surface() const { return surface_; }
    [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
    [[nodiscard]] double size() const { return surface_.scale().extent; }

    [[nodiscard]] std::vector<double> block_gaps(const Vec3& p) const
    {
        std::vector<double> gaps;
        for (const Box& box : boxes_)
            gaps.push_back((box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0).norm());
        return gaps;
    }
    [[nodiscard]] double distance(TriangleId id, const Vec3& p) const
    {
        return (closest_point(mesh_.triangle(id), p).point - p).norm();
    }

private:
    const TriangleMesh& mesh_;
    MeshIndex index_;
    IndexContactSurface surface_;
    std::vector<Box> boxes_;
};

struct Question {
    Vec3 place;
    double distance;
};

/// On corners, near, in the middle of it all and far off; nothing, a little, all there is and more.
Question question(const Everything& all, std::mt19937& random)
{
    std::uniform_real_distribution<double> unit(0, 1);
    const auto id = static_cast<std::uint32_t>(random() % all.mesh().triangle_count());
    const Triangle triangle = all.mesh().triangle(TriangleId{id});
    const Vec3 aside = Vec3(unit(random), unit(random), unit(random)) - Vec3::Constant(0.5);
    const std::array<Vec3, 4> places = {
        triangle[static_cast<int>(random() % 3)], triangle[0] + 0.1 * all.size() * aside,
        bounding_box(all.mesh()).center(), triangle[1] + 20 * all.size() * aside};
    const Vec3 place = places[random() % places.size()];
    const double near = all.distance(TriangleId{id}, place);
    const std::array<double, 6> distances = {
        0.0, 1e-9 * all.size(), near, unit(random) * unit(random) * all.size(), 2 * near, 1e30};
    return {place, distances[random() % distances.size()]};
}

/// What was taken is what the reach promises, each triangle once, and the reach is not needlessly
/// short.
void check_patch(const Everything& all, const ContactPatch& patch, const Question& asked,
                 std::size_t room, const std::string& what)
{
    std::set<TriangleId> there;
    for (const ContactTriangle& each : testing::triangles_of(patch)) {
        ASSERT_LT(to_index(each.id), all.mesh().triangle_count()) << what;
        EXPECT_EQ(each.corners[1], all.mesh().triangle(each.id)[1]) << what;
        EXPECT_TRUE(there.insert(each.id).second) << what;
    }
    EXPECT_LE(patch.count(), room) << what;
    if (patch.complete) {
        EXPECT_EQ(patch.reach, asked.distance) << what;
    } else {
        EXPECT_TRUE(patch.reach == 0 || (patch.reach > 0 && patch.reach < asked.distance)) << what;
    }
    if (patch.reach > 0 || patch.complete) {
        for (std::uint32_t id = 0; id < all.mesh().triangle_count(); ++id) {
            if (all.distance(TriangleId{id}, asked.place) > patch.reach) continue;
            ASSERT_TRUE(there.contains(TriangleId{id}))
                << what << ", triangle " << id << " at "
                << all.distance(TriangleId{id}, asked.place) << " within " << patch.reach;
        }
    }
    // What boxes are rounded by, and what distances of floats are told apart by.
    const double rounding = 1e-5 * (all.size() + asked.place.cwiseAbs().maxCoeff());
    const std::vector<double> gaps = all.block_gaps(asked.place);
    if (patch.complete) {
        const std::size_t most = blocks_within(gaps, asked.distance * (1 + 1e-5) + rounding);
        EXPECT_LE(patch.count(), most * block) << what;
        return;
    }
    EXPECT_GT(blocks_within(gaps, 1.03 * patch.reach + rounding), room / block)
        << what << ": a reach of " << patch.reach << " is too short";
}

TEST(NearGroups, HoldEveryTriangleWithinReach)
{
    std::uint32_t seed = 100;
    std::size_t cut_short = 0;
    std::size_t whole = 0;
    std::size_t nothing = 0;
    for (const TouchMesh& named : meshes()) {
        const Everything all(named.mesh);
        for (const std::size_t room :
             {std::size_t{1}, 3 * block, 16 * block, std::size_t{1} << 16U}) {
            ContactPatch patch(room);
            const std::size_t rounded = (room + block - 1) / block * block;
            std::mt19937 random(++seed);
            for (int round = 0; round < 60; ++round) {
                const Question asked = question(all, random);
                patch.refer(all.surface(), asked.place, asked.distance);
                cut_short += patch.complete ? 0U : 1U;
                whole += patch.complete ? 1U : 0U;
                nothing += patch.count() == 0 ? 1U : 0U;
                check_patch(all, patch, asked, rounded,
                            named.name + ", room " + std::to_string(room) + ", seed " +
                                std::to_string(seed) + ", round " + std::to_string(round));
                if (HasFatalFailure()) return;
            }
        }
    }
    std::printf("%zu whole, %zu cut short, %zu of nothing\n", whole, cut_short, nothing);
    EXPECT_GT(whole, 1000U);
    EXPECT_GT(cut_short, 500U);
    EXPECT_GT(nothing, 100U);
}

TEST(NearGroups, TakeAllOrNoneOfEquallyFarBlocks)
{
    const TriangleMesh mesh = two_heaps(10 * block, 20 * block);
    const Everything all(mesh);
    for (const std::size_t room : {10U, 11U, 20U, 29U, 30U, 40U}) {
        ContactPatch patch(room * block);
        patch.refer(all.surface(), Vec3::Zero(), 3);
        const bool all_fit = room >= 30;
        EXPECT_EQ(patch.complete, all_fit) << room;
        EXPECT_EQ(patch.count(), (all_fit ? 30 : 10) * block) << room;
        if (all_fit) continue;
        EXPECT_GT(patch.reach, 1.96) << room;
        EXPECT_LT(patch.reach, 2) << room;
    }
    // No room for the nearer heap: nothing, up to just before it.
    ContactPatch patch(9 * block);
    patch.refer(all.surface(), Vec3::Zero(), 3);
    EXPECT_FALSE(patch.complete);
    EXPECT_EQ(patch.count(), 0U);
    EXPECT_GT(patch.reach, 0.98);
    EXPECT_LT(patch.reach, 1);
    // On it: some of it, and no promise.
    patch.refer(all.surface(), Vec3(0, 0, 1), 0);
    EXPECT_FALSE(patch.complete);
    EXPECT_EQ(patch.count(), 9 * block);
    EXPECT_EQ(patch.reach, 0);
}

// A proxy's questions of a patch are answered with all of its triangles that are near.
TEST(NearGroups, AnswersMissNoNearTriangle)
{
    std::uint32_t seed = 900;
    std::size_t needed = 0;
    for (const TouchMesh& named : meshes()) {
        const Everything all(named.mesh);
        PatchContactSurface surface(all.surface().scale());
        ContactPatch patch(20 * block);
        std::vector<ContactTriangle> buffer(named.mesh.triangle_count());
        std::mt19937 random(++seed);
        std::uniform_real_distribution<double> unit(0, 1);
        for (int round = 0; round < 12; ++round) {
            const Question asked = question(all, random);
            patch.refer(all.surface(), asked.place, asked.distance);
            surface.use(&patch);
            const std::vector<ContactTriangle> whole = testing::triangles_of(patch);
            ContactCache cache;
            for (int i = 0; i < 6; ++i) {
                const Vec3 p = question(all, random).place;
                const double distance = 0.2 * unit(random) * all.size();
                const std::size_t count = i % 2 == 0 ? surface.collect(p, distance, buffer)
                                                     : cache.collect(surface, p, distance, buffer);
                ASSERT_LE(count, whole.size()) << named.name << ", seed " << seed;
                std::set<TriangleId> given;
                for (const ContactTriangle& each : std::span(buffer).first(count))
                    given.insert(each.id);
                EXPECT_EQ(given.size(), count) << named.name << ", seed " << seed;
                for (const ContactTriangle& each : whole) {
                    if ((closest_point(each.corners, p).point - p).norm() > distance) continue;
                    ++needed;
                    ASSERT_TRUE(given.contains(each.id))
                        << named.name << ", seed " << seed << ", round " << round;
                }
            }
        }
    }
    EXPECT_GT(needed, 5000U);
}

TEST(NearGroups, AreTheSameOnEveryInstructionSet)
{
    const TriangleMesh mesh = *sample_mesh("torus:60x30");
    const Everything all(mesh);
    struct Seen {
        double reach;
        std::vector<TriangleId> ids;
        bool operator==(const Seen&) const = default;
    };
    std::vector<Seen> expected;
    for (const SimdTarget& target : simd_targets()) {
        force_simd_target(target);
        std::vector<Seen> seen;
        std::mt19937 random(5);
        ContactPatch patch(12 * block);
        for (int round = 0; round < 100; ++round) {
            const Question asked = question(all, random);
            patch.refer(all.surface(), asked.place, asked.distance);
            Seen each{.reach = patch.reach, .ids = {}};
            for (const ContactTriangle& triangle : testing::triangles_of(patch))
                each.ids.push_back(triangle.id);
            seen.push_back(std::move(each));
        }
        if (expected.empty())
            expected = std::move(seen);
        else
            EXPECT_EQ(seen, expected) << target.name;
    }
    restore_simd_targets();
}

} // namespace
} // namespace proxima
