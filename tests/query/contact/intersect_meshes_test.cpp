#include "proxima/intersect_meshes.h"

#include "base/simd.h"
#include "cancellation.h"
#include "counted_allocations.h"
#include "index/test_meshes.h"
#include "mesh/random_soups.h"
#include "octree/nasty_meshes.h"
#include "octree/small_meshes.h"
#include "proxima/mesh_index.h"
#include "proxima/octree.h"
#include "query/contact/test_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

namespace proxima::intersect_meshes_test {
namespace {

using namespace testing;

MeshIndex index_of(const TriangleMesh& mesh)
{
    return build_mesh_index(mesh).value();
}

RigidTransform shifted(const Vec3& by)
{
    return {.translation = by};
}

/// Every kind of answer against brute force. Returns how many pairs meet.
std::size_t expect_truth(const TriangleMesh& mesh_a, const TriangleMesh& mesh_b, const MeshIndex& a,
                         const MeshIndex& b, const RigidTransform& pose)
{
    const std::vector<TrianglePair> truth = pairs_by_brute_force(mesh_a, mesh_b, pose);
    EXPECT_EQ(intersecting_pairs(a, b, pose), truth);
    EXPECT_EQ(meshes_intersect(a, b, pose), !truth.empty());
    return truth.size();
}

/// Counts of what was tried, so that a test is known to have tried something.
struct Tally {
    std::size_t poses = 0;
    std::size_t meeting = 0;
    std::size_t pairs = 0;

    void try_poses(const TriangleMesh& mesh_a, const TriangleMesh& mesh_b, int count,
                   std::uint64_t seed)
    {
        const MeshIndex a = index_of(mesh_a);
        const MeshIndex b = index_of(mesh_b);
        PoseGenerator generate(mesh_a, mesh_b, seed);
        for (int i = 0; i < count; ++i) {
            SCOPED_TRACE(::testing::Message() << "seed " << seed << ", pose " << i);
            const std::size_t met = expect_truth(mesh_a, mesh_b, a, b, generate());
            ++poses;
            meeting += met > 0 ? 1 : 0;
            pairs += met;
            if (::testing::Test::HasFailure()) return;
        }
    }
};

TEST(IntersectMeshes, AnswersLikeBruteForceOnNamedMeshes)
{
    Tally tally;
    const std::vector<NamedMesh> meshes = proximity_meshes();
    std::uint64_t seed = 1;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        for (const std::size_t other : {i, (i + 1) % meshes.size(), (i * 7 + 3) % meshes.size()}) {
            SCOPED_TRACE(meshes[i].name + " and " + meshes[other].name);
            tally.try_poses(meshes[i].mesh, meshes[other].mesh, 12, seed++);
            if (HasFailure()) return;
        }
    }
    EXPECT_GT(tally.meeting, tally.poses / 3);
    EXPECT_LT(tally.meeting, tally.poses * 19 / 20);
    EXPECT_GT(tally.pairs, 20'000U);
}

TEST(IntersectMeshes, AnswersLikeBruteForceOnManyRandomMeshes)
{
    Tally tally;
    for (std::uint32_t seed = 0; seed < 300; ++seed) {
        const TriangleMesh nasty = nasty_mesh(seed);
        const TriangleMesh grid = grid_mesh(seed);
        const TriangleMesh soup = random_soup(seed);
        tally.try_poses(nasty, nasty_mesh(seed / 2), 4, seed);
        tally.try_poses(grid, grid_mesh(seed + 1), 10, seed);
        if (checked_bounding_box(soup)) tally.try_poses(soup, grid, 10, seed);
        if (HasFailure()) return;
    }
    EXPECT_GT(tally.meeting, tally.poses / 3);
    EXPECT_LT(tally.meeting, tally.poses * 19 / 20);
    EXPECT_GT(tally.pairs, 50'000U);
}

TEST(IntersectMeshes, AnswersLikeBruteForceForAMeshAgainstItself)
{
    // With one index on both sides, a leaf of one side may be the next one of the other.
    std::size_t pairs = 0;
    for (const double height : {1.0, 1e-4, 0.0}) {
        const TriangleMesh mesh = moved(torus_mesh(1.0, 0.4, 24, 16), [&](const Vec3& p) {
            return Vec3(p.x(), p.y(), height * p.z());
        });
        const MeshIndex index = index_of(mesh);
        PoseGenerator generate(mesh, mesh, 5);
        for (int i = 0; i < 100; ++i) pairs += expect_truth(mesh, mesh, index, index, generate());
    }
    EXPECT_GT(pairs, 20'000U);
}

TEST(IntersectMeshes, AnswersLikeBruteForceWhereMeshesBarelyTouch)
{
    // Leaves side by side, whose slabs nearly touch: on round meshes, and on flat ones, where slabs
    // have no thickness.
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const TriangleMesh sphere = sphere_mesh(Vec3(0.3, 0.2, 0.1), 0.8, 12, 16);
    const TriangleMesh flat = moved(torus, [](const Vec3& p) { return Vec3(p.x(), p.y(), 0); });
    const TriangleMesh small = moved(sphere, [](const Vec3& p) { return Vec3(p * 0x1p-7); });
    const TriangleMesh meshes[] = {torus, sphere, flat, small};
    std::vector<MeshIndex> indexes;
    for (const TriangleMesh& mesh : meshes) indexes.push_back(index_of(mesh));
    std::size_t apart = 0;
    std::size_t meeting = 0;
    for (std::size_t i = 0; i < indexes.size(); ++i) {
        for (std::size_t j = 0; j < indexes.size(); ++j) {
            SCOPED_TRACE(::testing::Message() << "meshes " << i << " and " << j);
            const MeshIndex& a = indexes[i]; // also the same index on both sides
            const MeshIndex& b = indexes[j];
            PoseGenerator generate(meshes[i], meshes[j], 21);
            for (int turn = 0; turn < 3; ++turn) {
                RigidTransform pose = generate();
                const Vec3 start = pose.translation;
                const auto at = [&](double distance) {
                    pose.translation = start + Vec3(0.25, 0.5, 1) * distance;
                    return pose;
                };
                double touching = 0;
                double beyond = 8;
                while (beyond - touching > 1e-12) {
                    const double middle = (touching + beyond) / 2;
                    (meshes_intersect(a, b, at(middle)) ? touching : beyond) = middle;
                }
                for (const double gap : {-1e-3, -1e-6, -1e-8, 0.0, 1e-8, 1e-6, 1e-3}) {
                    const std::size_t pairs =
                        expect_truth(meshes[i], meshes[j], a, b, at(touching + gap));
                    ++(pairs == 0 ? apart : meeting);
                }
            }
        }
    }
    EXPECT_GT(apart, 100U);
    EXPECT_GT(meeting, 100U);
}

TEST(IntersectMeshes, FindsCubesThatTouch)
{
    const TriangleMesh cube = cube_mesh(Vec3(0.5, 0.5, 0.5), 0.5);
    const MeshIndex index = index_of(cube);
    const auto pairs = [&](const Vec3& by) {
        const RigidTransform pose = shifted(by);
        EXPECT_EQ(meshes_intersect(index, index, pose),
                  expect_truth(cube, cube, index, index, pose) > 0);
        return intersecting_pairs(index, index, pose).size();
    };
    EXPECT_GT(pairs(Vec3(0, 0, 0)), 12U); // each with itself, and with its neighbours
    EXPECT_GT(pairs(Vec3(1, 0, 0)), 4U);  // in a face
    EXPECT_GT(pairs(Vec3(1, 1, 0)), 1U);  // in an edge
    EXPECT_GT(pairs(Vec3(1, 1, 1)), 0U);  // in a corner
    const double bit = 0x1p-52;
    EXPECT_EQ(pairs(Vec3(1 + bit, 0, 0)), 0U);
    EXPECT_EQ(pairs(Vec3(1 + bit, 1, 0)), 0U);
    EXPECT_EQ(pairs(Vec3(1, 1 + bit, 1)), 0U);
    EXPECT_EQ(pairs(Vec3(1, 1, -1 - bit)), 0U);
    EXPECT_GT(pairs(Vec3(1 - bit / 2, 1 - bit / 2, 1 - bit / 2)), 0U);
}

TEST(IntersectMeshes, IsSymmetric)
{
    const TriangleMesh mesh_a = torus_mesh(1.0, 0.4, 24, 16);
    const TriangleMesh mesh_b = sphere_mesh(Vec3(0.25, 0.5, 0), 0.5, 14, 18);
    // On a grid of 2^-20 so that points move without rounding.
    const auto snapped = [](const TriangleMesh& mesh) {
        return moved(mesh, [](const Vec3& p) {
            return Vec3((p * 0x1p20).array().round().matrix() * 0x1p-20);
        });
    };
    const TriangleMesh a = snapped(mesh_a);
    const TriangleMesh b = snapped(mesh_b);
    const MeshIndex index_a = index_of(a);
    const MeshIndex index_b = index_of(b);
    std::mt19937 random(5);
    std::size_t found = 0;
    for (int i = 0; i < 100; ++i) {
        const auto step = [&] { return std::ldexp(static_cast<double>(random() % 65) - 32, -5); };
        const double x = step();
        const double y = step();
        const Vec3 by(x, y, step());
        std::vector<TrianglePair> pairs = intersecting_pairs(index_a, index_b, shifted(by));
        std::vector<TrianglePair> back = intersecting_pairs(index_b, index_a, shifted(-by));
        for (TrianglePair& pair : back) std::swap(pair.a, pair.b);
        std::ranges::sort(back);
        EXPECT_EQ(back, pairs);
        EXPECT_TRUE(std::ranges::is_sorted(pairs));
        EXPECT_EQ(std::ranges::adjacent_find(pairs), pairs.end());
        found += pairs.size();
    }
    EXPECT_GT(found, 1000U);
}

TEST(IntersectMeshes, AnswersTheSameAtAnyScaleAndPosition)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const TriangleMesh sphere = sphere_mesh(Vec3(0.3, 0.2, 0.1), 0.8, 12, 16);
    const MeshIndex a = index_of(torus);
    const MeshIndex b = index_of(sphere);
    for (const int exponent : {-20, 20, -200, 200}) {
        SCOPED_TRACE(exponent);
        const double scale = std::ldexp(1.0, exponent);
        const auto scaled = [&](const TriangleMesh& mesh) {
            return index_of(moved(mesh, [&](const Vec3& p) { return Vec3(scale * p); }));
        };
        const MeshIndex other_a = scaled(torus);
        const MeshIndex other_b = scaled(sphere);
        PoseGenerator generate(torus, sphere, 3);
        for (int i = 0; i < 30; ++i) {
            const RigidTransform pose = generate();
            const RigidTransform same = {pose.rotation, scale * pose.translation};
            ASSERT_EQ(intersecting_pairs(other_a, other_b, same), intersecting_pairs(a, b, pose));
        }
    }
    // Of very different sizes, and where coordinates are coarse: each by brute force.
    Tally tally;
    const auto placed = [&](double scale, const Vec3& at) {
        return moved(torus, [&](const Vec3& p) { return Vec3(scale * p + at); });
    };
    const Vec3 far(3e7, -5e8, 2e9);
    tally.try_poses(placed(1, far), sphere, 20, 1);
    tally.try_poses(sphere, placed(1, far), 20, 2);
    tally.try_poses(placed(1e3, far), placed(1, -far), 20, 3);
    tally.try_poses(placed(1e-6, Vec3::Zero()), sphere, 20, 4);
    tally.try_poses(sphere, placed(1e6, Vec3::Zero()), 20, 5);
    tally.try_poses(placed(1e-3, 1e-6 * far), placed(1e3, 1e-3 * far), 20, 6);
    tally.try_poses(placed(1e-60, Vec3::Zero()), placed(1e60, Vec3::Zero()), 20, 7);
    // So far that floats are of no use.
    tally.try_poses(placed(1e-3, 1e5 * far), cube_mesh(Vec3::Zero(), 0.125), 20, 8);
    EXPECT_GT(tally.meeting, tally.poses / 3);
    EXPECT_LT(tally.meeting, tally.poses);
}

TEST(IntersectMeshes, AcceptsMeshesOfOneLeafAndEmptyOnes)
{
    const TriangleMesh one = mesh_of({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, {{0, 1, 2}});
    const TriangleMesh point = mesh_of({Vec3(0.25, 0.25, 0)}, {{0, 0, 0}});
    const TriangleMesh sphere = sphere_mesh(Vec3::Zero(), 1.0, 20, 30);
    const MeshIndex a = index_of(one);
    const MeshIndex b = index_of(point);
    EXPECT_TRUE(meshes_intersect(a, b, {}));
    EXPECT_TRUE(meshes_intersect(b, a, {}));
    EXPECT_TRUE(meshes_intersect(b, b, {}));
    EXPECT_FALSE(meshes_intersect(a, b, shifted(Vec3(0, 0, 0x1p-1000))));
    EXPECT_FALSE(meshes_intersect(b, b, shifted(Vec3(0, 0, -0x1p-1000))));
    Tally tally;
    tally.try_poses(one, sphere, 50, 1);
    tally.try_poses(sphere, one, 50, 2);
    tally.try_poses(sphere, point, 50, 3);
    tally.try_poses(one, point, 50, 4);
    const MeshIndex empty;
    EXPECT_FALSE(meshes_intersect(empty, a, {}));
    EXPECT_FALSE(meshes_intersect(a, empty, {}));
    EXPECT_TRUE(intersecting_pairs(empty, empty, RigidTransform()).empty());
}

TEST(IntersectMeshes, FindsNothingForPosesThatOverflow)
{
    const MeshIndex sphere = index_of(sphere_mesh(Vec3::Zero(), 1.0, 5, 6));
    const double most = std::numeric_limits<double>::max();
    for (const double t : {most, std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN()}) {
        EXPECT_FALSE(meshes_intersect(sphere, sphere, shifted(Vec3(0, t, 0))));
        EXPECT_TRUE(intersecting_pairs(sphere, sphere, shifted(Vec3(t, t, t))).empty());
    }
}

TEST(IntersectMeshes, AnswersTheSameOnEveryInstructionSetWithoutAllocating)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const TriangleMesh soup = nasty_mesh(5);
    const MeshIndex a = index_of(torus);
    const MeshIndex b = index_of(soup);
    PoseGenerator generate(torus, soup, 13);
    std::vector<RigidTransform> poses(200);
    for (RigidTransform& pose : poses) pose = generate();
    std::vector<std::vector<TrianglePair>> truth;
    std::size_t meeting = 0;
    for (const RigidTransform& pose : poses) {
        truth.push_back(pairs_by_brute_force(torus, soup, pose));
        meeting += truth.back().empty() ? 0 : 1;
    }
    EXPECT_GT(meeting, 20U);
    EXPECT_LT(meeting, poses.size());
    std::array<TrianglePair, 5> first_pairs;
    for (const SimdTarget& target : simd_targets()) {
        SCOPED_TRACE(target.name);
        force_simd_target(target);
        const std::size_t before = allocation_count();
        std::size_t wrong = 0;
        MeshMeeting last;
        for (std::size_t i = 0; i < poses.size(); ++i) {
            if (meshes_intersect(a, b, poses[i]) == truth[i].empty()) ++wrong;
            const auto met = find_meeting(a, b, poses[i], {.start_from = &last});
            if (met.has_value() == truth[i].empty()) ++wrong;
            if (met && !std::ranges::binary_search(truth[i],
                                                   TrianglePair{met->triangle_a, met->triangle_b}))
                ++wrong;
            last = met.value_or(last);
            if (intersecting_pairs(a, b, poses[i], first_pairs) != truth[i].size()) ++wrong;
            const std::size_t kept = std::min(first_pairs.size(), truth[i].size());
            if (!std::equal(first_pairs.begin(),
                            first_pairs.begin() + static_cast<std::ptrdiff_t>(kept),
                            truth[i].begin()))
                ++wrong;
        }
        EXPECT_EQ(allocation_count(), before);
        EXPECT_EQ(wrong, 0U);
        for (std::size_t i = 0; i < poses.size(); ++i)
            EXPECT_EQ(intersecting_pairs(a, b, poses[i]), truth[i]);
        restore_simd_targets();
    }
}

TEST(IntersectMeshes, FollowsAMovingMesh)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const MeshIndex index = index_of(torus);
    std::optional<MeshMeeting> last;
    std::size_t kept = 0;
    for (int i = 0; i < 400; ++i) {
        const RigidTransform pose = shifted(Vec3(0.01 * i, 0.001 * i, 0));
        const auto met = find_meeting(index, index, pose, {.start_from = last ? &*last : nullptr});
        EXPECT_EQ(met.has_value(), meshes_intersect(index, index, pose));
        kept += met && last && met->row_a == last->row_a ? 1 : 0;
        last = met;
    }
    EXPECT_FALSE(last);
    EXPECT_GT(kept, 50U);
    // An answer of other meshes does no harm.
    const MeshMeeting other = {{}, {}, 1'000'000, 7};
    const auto met = find_meeting(index, index, {}, {.start_from = &other});
    ASSERT_TRUE(met);
    EXPECT_LT(met->row_a, torus.triangle_count());
}

TEST(IntersectMeshes, StopsWhereTheVisitorSaysSo)
{
    const MeshIndex index = index_of(torus_mesh(1.0, 0.4, 24, 16));
    const RigidTransform pose = shifted(Vec3(0.1, 0.05, 0));
    std::size_t calls = 0;
    visit_intersecting_pairs(index, index, pose, [&](std::span<const TrianglePair> pairs) {
        EXPECT_FALSE(pairs.empty());
        ++calls;
        return Flow::stop;
    });
    EXPECT_EQ(calls, 1U);
    EXPECT_GT(intersecting_pairs(index, index, pose).size(), 256U); // more than one call's
    // Also so far away that every pair is tested.
    const auto away = [](const Vec3& p) { return Vec3(p + 1e5 * Vec3(3e7, -5e8, 2e9)); };
    const MeshIndex far = index_of(moved(torus_mesh(1.0, 0.4, 24, 16), away));
    calls = 0;
    visit_intersecting_pairs(far, far, {}, [&](std::span<const TrianglePair> pairs) {
        EXPECT_FALSE(pairs.empty());
        ++calls;
        return Flow::stop;
    });
    EXPECT_EQ(calls, 1U);
    EXPECT_GT(intersecting_pairs(far, far, RigidTransform{}).size(), 1U);
}

TEST(IntersectMeshes, StopsWhereTheVisitorSaysSoThoughNoneMeet)
{
    const MeshIndex outer = index_of(torus_mesh(1.0, 0.4, 160, 80));
    const MeshIndex inner = index_of(torus_mesh(1.0, 0.39999, 160, 80));
    std::size_t calls = 0;
    const auto count = [&](Flow flow) {
        calls = 0;
        visit_intersecting_pairs(outer, inner, {}, [&](std::span<const TrianglePair> pairs) {
            EXPECT_TRUE(pairs.empty());
            ++calls;
            return flow;
        });
        return calls;
    };
    EXPECT_GT(count(Flow::proceed), 5U);
    EXPECT_EQ(count(Flow::stop), 1U);
}

TEST(IntersectMeshes, BatchesAnswerLikeSinglePosesForAnyNumberOfThreads)
{
    const TriangleMesh torus = torus_mesh(1.0, 0.4, 24, 16);
    const TriangleMesh sphere = sphere_mesh(Vec3(0.3, 0.2, 0.1), 0.8, 12, 16);
    const MeshIndex a = index_of(torus);
    const MeshIndex b = index_of(sphere);
    PoseGenerator generate(torus, sphere, 17);
    std::vector<RigidTransform> poses(50);
    for (RigidTransform& pose : poses) pose = generate();
    for (const int threads : {1, 3}) {
        const auto answers = std::make_unique<bool[]>(poses.size());
        const PairOptions options{.execution = {.threads = {threads}}};
        ASSERT_TRUE(meshes_intersect(a, b, poses, {answers.get(), poses.size()}, options));
        const auto lists = intersecting_pairs(a, b, poses, options);
        ASSERT_TRUE(lists);
        ASSERT_EQ(lists->first.size(), poses.size() + 1);
        for (std::size_t i = 0; i < poses.size(); ++i) {
            EXPECT_EQ(answers[i], meshes_intersect(a, b, poses[i]));
            const std::vector<TrianglePair> own(
                lists->pairs.begin() + static_cast<std::ptrdiff_t>(lists->first[i]),
                lists->pairs.begin() + static_cast<std::ptrdiff_t>(lists->first[i + 1]));
            EXPECT_EQ(own, intersecting_pairs(a, b, poses[i]));
        }
        EXPECT_FALSE(meshes_intersect(a, b, poses, {answers.get(), 7}, options));
    }
    cancel_at_every_stage(
        [&](Progress& progress) {
            return intersecting_pairs(a, b, poses, {.execution = {.progress = &progress}});
        },
        [] { return true; });
}

TEST(IntersectMeshes, MeetsWhatItMeetsHoweverLargeMeshesAre)
{
    const auto index_of = [](std::vector<Vec3> corners) {
        return build_mesh_index(mesh_of(std::move(corners), {{0, 1, 2}})).value();
    };
    const MeshIndex needle = index_of({Vec3(0, 1, -1), Vec3(0, 1, 1), Vec3(0, 1, 1)});
    const MeshIndex beside = index_of({Vec3(0, 1, 1), Vec3(0, 1, 2), Vec3(0, 1, 2)});
    const MeshIndex at_corner = index_of({Vec3(0, 1, 0), Vec3(0, 2, 0), Vec3(0, 2, 1)});
    for (const double size : {1.0, 1e100, 1e301, 2.2e301, 1e303, 4e307}) {
        SCOPED_TRACE(::testing::Message() << "size " << size);
        const MeshIndex large =
            index_of({Vec3(-2 * size, 0, 0), Vec3(2 * size, 0, 0), Vec3(0, 2 * size, 0)});
        const MeshIndex corner = index_of({Vec3(size, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)});
        for (const auto& [a, b, meet] :
             {std::tuple(&large, &needle, true), std::tuple(&large, &beside, false),
              std::tuple(&corner, &at_corner, true)}) {
            EXPECT_EQ(meshes_intersect(*a, *b), meet);
            EXPECT_EQ(meshes_intersect(*b, *a), meet);
            EXPECT_EQ(find_meeting(*a, *b).has_value(), meet);
            EXPECT_EQ(intersecting_pairs(*a, *b, RigidTransform()).size(), meet ? 1U : 0U);
        }
    }
}

} // namespace
} // namespace proxima::intersect_meshes_test
