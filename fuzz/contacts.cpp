// Overlap, penetration depth and times of contact of solids made of any tetrahedra, against all pairs
// of triangles and exact winding numbers.
#include "proxima/contacts.h"
#include "base/check.h"
#include "decoded_mesh.h"
#include "geometry/exact_predicates.h"
#include "geometry/triangle_contact.h"
#include "oracles/exact_winding.h"
#include "proxima/mesh_index.h"
#include "proxima/time_of_contact.h"
#include "query/contact/test_poses.h"
#include "query/contacts/random_motions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace {

using namespace proxima;

/// One to four tetrahedra with vertices of their own, that reach into each other or touch; nothing where
/// all are flat.
std::optional<TriangleMesh> decode_tetrahedra(fuzz::Bytes& bytes, const fuzz::PositionCode& code)
{
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    for (int count = 1 + bytes.next() % 4; count > 0; --count) {
        std::array<Vec3, 4> corners;
        for (Vec3& corner : corners) corner = code.next(bytes);
        const int side = orient3d(corners[0], corners[1], corners[2], corners[3]);
        if (side == 0) continue;
        if (side > 0) std::swap(corners[0], corners[1]);
        const auto at = static_cast<std::uint32_t>(positions.size());
        positions.insert(positions.end(), corners.begin(), corners.end());
        for (const TriangleCorners& c : {TriangleCorners{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}})
            triangles.push_back({at + c[0], at + c[1], at + c[2]});
    }
    if (triangles.empty()) return std::nullopt;
    return *make_triangle_mesh(std::move(positions), std::move(triangles));
}

bool surfaces_meet(const TriangleMesh& a, const TriangleMesh& b, const RigidTransform& pose)
{
    return !testing::pairs_by_brute_force(a, b, pose).empty();
}

bool has_inside(const TriangleMesh& mesh, const Vec3& p)
{
    const auto winding = oracle::exact_winding(mesh, p);
    return winding && *winding != 0; // what is on the surface, meets it
}

TriangleMesh moved(const TriangleMesh& mesh, const RigidTransform& pose)
{
    std::vector<Vec3> positions;
    for (const Vec3& p : mesh.positions()) positions.push_back(pose(p));
    return *make_triangle_mesh(std::move(positions),
                               {mesh.triangles().begin(), mesh.triangles().end()});
}

bool overlap_by_brute_force(const TriangleMesh& a, const TriangleMesh& b,
                            const RigidTransform& pose)
{
    if (surfaces_meet(a, b, pose)) return true;
    const TriangleMesh there = moved(b, pose);
    return std::ranges::any_of(a.positions(),
                               [&](const Vec3& p) { return has_inside(there, p); }) ||
           std::ranges::any_of(there.positions(), [&](const Vec3& p) { return has_inside(a, p); });
}

void expect_depth(const Solid& a, const Solid& b, const TriangleMesh& mesh_a,
                  const TriangleMesh& mesh_b, const RigidTransform& pose, std::mt19937_64& random)
{
    const bool overlap = overlap_by_brute_force(mesh_a, mesh_b, pose);
    PROXIMA_CHECK_EQ(solids_overlap(a, b, pose), overlap);
    const auto found =
        penetration_depth(a, b, pose, {.max_points = 100, .max_directions = 8}).value();
    PROXIMA_CHECK_EQ(found.method != PenetrationMethod::apart, overlap);
    PROXIMA_CHECK_EQ(contact_regions(a, b, pose).value().regions.empty(),
                     !surfaces_meet(mesh_a, mesh_b, pose));
    if (!overlap) return;
    PROXIMA_CHECK_LE(found.lower, found.upper);
    const auto overlaps_by = [&](const Vec3& translation) {
        return overlap_by_brute_force(mesh_a, mesh_b,
                                      {pose.rotation, pose.translation + translation});
    };
    PROXIMA_CHECK(!overlaps_by(found.translation));
    for (int i = 0; i < 4; ++i) {
        const Vec3 direction = i == 0 ? found.direction : testing::random_direction(random);
        PROXIMA_CHECK(overlaps_by((1 - 1e-9) * found.lower * direction));
    }
}

void expect_time(const Solid& a, const Solid& b, const TriangleMesh& mesh_a,
                 const TriangleMesh& mesh_b, const RigidMotion& motion)
{
    const auto found = time_of_contact(a.index(), b.index(), motion, {.max_steps = 20'000});
    const double end = found ? found->free_until : 1;
    constexpr int steps = 12;
    for (int i = 0; i <= steps; ++i) {
        const double time = end * i / steps;
        if (found && time == 0) continue; // they meet at the start, perhaps
        PROXIMA_CHECK(!surfaces_meet(mesh_a, mesh_b, pose_at(motion, time)));
    }
    if (found && found->evidence == ContactEvidence::intersection) {
        PROXIMA_CHECK_LE(found->free_until, found->touches_at);
        PROXIMA_CHECK(surfaces_meet(mesh_a, mesh_b, pose_at(motion, found->touches_at)));
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const std::uint32_t seed = bytes.next_word();
    const fuzz::PositionCode code(bytes);
    const auto mesh_a = decode_tetrahedra(bytes, code);
    const auto mesh_b = decode_tetrahedra(bytes, code);
    if (!mesh_a || !mesh_b) return 0;
    const Execution alone{.threads = {1}};
    const auto solid_of = [&](const TriangleMesh& mesh) {
        return build_solid(build_mesh_index(mesh, {.execution = alone}).value(),
                           {.execution = alone});
    };
    const auto a = solid_of(*mesh_a);
    const auto b = solid_of(*mesh_b);
    if (!a || !b) return 0; // refused, as coordinates above the limit are
    std::mt19937_64 random(seed);
    testing::PoseGenerator pose(*mesh_a, *mesh_b, seed);
    for (const RigidTransform& at : {RigidTransform(), pose()})
        expect_depth(*a, *b, *mesh_a, *mesh_b, at, random);
    expect_time(*a, *b, *mesh_a, *mesh_b, testing::MotionGenerator(*mesh_a, *mesh_b, seed)());
    expect_time(*a, *b, *mesh_a, *mesh_b,
                {.start = pose(), .displacement = fuzz::decode_point(bytes, code, *mesh_b)});
    return 0;
}
