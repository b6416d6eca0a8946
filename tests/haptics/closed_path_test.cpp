// What closed paths without friction take, and why it is no more than the size of a tick makes it.
//
// Seen from a room (the inside of a cube, of a sphere) the places that are free are convex: the
// closest of them, c(q), is one, and the spring has the potential U = K / 2 |q - c(q)|^2. Its slope
// is straight within a region, where c is on one face, one edge or one corner, and it bends at the
// seams between them, nowhere by more than K:
//
//     one tick of length h    | trapezoid - (U(q) - U(q before)) |  = 0          within a region
//                                                                  <= K h^2 / 8  across seams
//     a force held over it      trapezoid - held                   in [0, K h^2 / 2]
//
// Round a closed path U adds up to nothing. So a path of n ticks takes no more than its seams make
// of it, as 1 / n^2, and no bound here is a chosen one.
//
// Seen from outside, an edge lets go of a device that goes round it under the surface: such paths
// take energy, and must never give any.
#include "haptics/force/surface_renderer.h"
#include "haptics/spring_alone.h"
#include "haptics/surface/contact_surface.h"
#include "haptics/touch_meshes.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "query/closest/brute_force.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>

namespace proxima::closed_path_test {
namespace {

constexpr double stiffness = 500;
constexpr double tick_seconds = 1e-3;
/// m: what coordinates of a workspace of 0.2 m are off by after some roundings.
constexpr double rounding = 0x1p-46 * 0.2;

DeviceState at(const Vec3& p)
{
    DeviceState state;
    state.pose.translation = p;
    return state;
}

/// A smooth closed path: sums of sines about a middle, by seed.
class Loop {
public:
    Loop(const Vec3& middle, double size, std::uint64_t seed) : middle_(middle)
    {
        std::mt19937_64 random(seed);
        std::normal_distribution<double> normal;
        for (std::size_t i = 0; i < sines_.size(); ++i) {
            const double share = size / static_cast<double>(i + 1);
            sines_[i] = share * Vec3{normal(random), normal(random), normal(random)};
            cosines_[i] = share * Vec3{normal(random), normal(random), normal(random)};
        }
    }
    [[nodiscard]] Vec3 place(int tick, int ticks) const
    {
        const double part = static_cast<double>(tick % ticks) / ticks;
        Vec3 p = middle_;
        for (std::size_t i = 0; i < sines_.size(); ++i) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(i + 1) * part;
            p += std::sin(angle) * sines_[i] + std::cos(angle) * cosines_[i];
        }
        return p;
    }

private:
    Vec3 middle_;
    std::array<Vec3, 3> sines_;
    std::array<Vec3, 3> cosines_;
};

/// A renderer that has gone from a free place to the beginning of a loop.
class Walk {
public:
    Walk(const TriangleMesh& mesh, const Vec3& from, const Vec3& to)
        : surface_(mesh), map_(map_of(mesh)),
          renderer_(make_surface_renderer(surface_, map_, device(), options()))
    {
        constexpr int steps = 1000;
        for (int step = 0; step < steps; ++step)
            renderer_.tick(at(from + step / double{steps} * (to - from)), tick_seconds);
        renderer_.tick(at(to), tick_seconds);
    }

    static WorkspaceMap map_of(const TriangleMesh& mesh)
    {
        return fit_workspace(bounding_box(mesh), 0.1);
    }
    [[nodiscard]] const RenderTick& last() const { return renderer_.last(); }
    const RenderTick& go(const Vec3& p) { return renderer_.tick(at(p), tick_seconds); }

private:
    static DeviceLimits device()
    {
        DeviceLimits limits = *find_device("delta");
        limits.max_force = 1e6;
        return limits;
    }
    static RenderOptions options() { return testing::spring_alone(stiffness); }

    MeshContactSurface surface_;
    WorkspaceMap map_;
    HapticRenderer renderer_;
};

/// The free place that is closest to a place, m, and in which region that one is: of a feature of
/// the mesh, or none where it is free itself.
struct FreePlace {
    Vec3 place = Vec3::Zero();
    std::optional<Feature> region;
};

/// A convex body, seen from inside, by all of its triangles.
class Room {
public:
    explicit Room(const TriangleMesh& body)
        : mesh_(testing::inverted(body)), topology_(*build_topology(mesh_)),
          map_(Walk::map_of(mesh_))
    {}

    [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
    /// Of the mesh's middle to its farthest corner, m.
    [[nodiscard]] Vec3 corner(std::size_t vertex) const
    {
        return map_.to_device(mesh_.positions()[vertex]);
    }

    [[nodiscard]] FreePlace closest(const Vec3& device) const
    {
        const Vec3 q = map_.to_model(device);
        const auto is_behind = [&](std::uint32_t id) {
            const Triangle triangle = mesh_.triangle(TriangleId{id});
            return scaled_normal(triangle).dot(q - triangle[0]) < 0;
        };
        bool free = true;
        for (std::uint32_t id = 0; id < mesh_.triangle_count() && free; ++id) free = !is_behind(id);
        if (free) return {device, std::nullopt};
        const ClosestFeature found = closest_feature_by_brute_force(mesh_, topology_, q);
        return {map_.to_device(found.point), found.feature};
    }

private:
    TriangleMesh mesh_;
    Topology topology_;
    WorkspaceMap map_;
};

/// Of a closed path in a room: energies in J, lengths in m.
struct ClosedPath {
    double trapezoid = 0;
    double held = 0;      ///< of forces that are held over the next tick, as devices do
    double most = 0;      ///< of |trapezoid|, by the seams
    double most_held = 0; ///< of trapezoid - held
    double depth = 0;     ///< the greatest
    int seams = 0;        ///< ticks that crossed some
    double astray = 0;    ///< of the place that the spring pulls to, from the closest one
    double within = 0;    ///< of |trapezoid - dU|, over K depth: the most within a region
    double across = 0;    ///< the same over K h^2 / 8, across seams, less rounding
    double early = 0;     ///< of held - trapezoid, over K h^2 / 2, less rounding
    double late = 0;      ///< of trapezoid - held, over that

    [[nodiscard]] double unit() const { return stiffness * depth * depth; }
};

ClosedPath go_round(const Room& room, const Loop& loop, int ticks)
{
    Walk walk(room.mesh(), Vec3::Zero(), loop.place(0, ticks));
    const auto potential = [](const Vec3& q, const FreePlace& free) {
        return stiffness / 2 * (free.place - q).squaredNorm();
    };
    ClosedPath sum;
    double length = 0;
    Vec3 force = walk.last().force;
    Vec3 before = walk.last().position;
    FreePlace free = room.closest(before);
    for (int tick = 1; tick <= ticks; ++tick) {
        const RenderTick& felt = walk.go(loop.place(tick, ticks));
        const FreePlace next = room.closest(felt.position);
        const Vec3 way = felt.position - before;
        const double h = way.norm();
        const double trapezoid = -0.5 * (felt.force + force).dot(way);
        const double held = -force.dot(way);
        const double off = trapezoid - (potential(felt.position, next) - potential(before, free));
        const double depth =
            std::max((next.place - felt.position).norm(), (free.place - before).norm());
        const double rounded = 2 * stiffness * (depth + rounding) * rounding;
        if (next.region == free.region) {
            sum.within = std::max(sum.within, std::abs(off) / (stiffness * (depth + rounding)));
        } else {
            ++sum.seams;
            sum.most += stiffness * h * h / 8;
            sum.across = std::max(sum.across, (std::abs(off) - rounded) / (stiffness * h * h / 8));
        }
        const double whole = stiffness * h * h / 2;
        sum.early = std::max(sum.early, (held - trapezoid - rounded) / whole);
        sum.late = std::max(sum.late, (trapezoid - held - rounded) / whole);
        sum.most_held += next.region || free.region ? whole : 0;
        sum.trapezoid += trapezoid;
        sum.held += held;
        sum.depth = std::max(sum.depth, depth);
        sum.astray = std::max(
            sum.astray, (felt.force - stiffness * (next.place - felt.position)).norm() / stiffness);
        length += h;
        force = felt.force;
        before = felt.position;
        free = next;
    }
    sum.most += stiffness * rounding * length;
    sum.most_held += stiffness * rounding * length;
    return sum;
}

/// All that theory says of a path.
void expect_as_derived(const ClosedPath& path, const std::string& name)
{
    EXPECT_GT(path.depth, 0.002) << name;
    EXPECT_GT(path.seams, 4) << name;
    EXPECT_LE(path.astray, rounding) << name;
    EXPECT_LE(path.within, 2 * rounding) << name;
    EXPECT_LE(path.across, 1 + 1e-9) << name;
    EXPECT_LE(std::abs(path.trapezoid), path.most) << name;
    EXPECT_LE(path.early, 1e-9) << name;
    EXPECT_LE(path.late, 1 + 1e-9) << name;
    EXPECT_LE(path.trapezoid - path.held, path.most_held) << name;
    const std::string key = "energy_" + name;
    ::testing::Test::RecordProperty(
        key, std::to_string(1e9 * path.trapezoid / path.unit()) + "e-9 of at most " +
                 std::to_string(1e9 * path.most / path.unit()) + "e-9, held " +
                 std::to_string(path.held / path.unit()));
}

TEST(ClosedPath, InACubeDissipatesLessThanABillionth)
{
    const Room room(*sample_mesh("cube"));
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        // About a corner of the room, through its walls, edges and the corner itself.
        const ClosedPath path = go_round(room, Loop(room.corner(7), 0.006, seed), 200000);
        expect_as_derived(path, "cube_" + std::to_string(seed));
        EXPECT_LT(std::abs(path.trapezoid), 1e-9 * path.unit());
        EXPECT_LT(std::abs(path.held), 5e-3 * path.unit());
    }
}

TEST(ClosedPath, InRoomsOfManyWallsDissipatesWhatItsSeamsPredict)
{
    // The corners of the finer sphere jammed proxies, by rounding where its triangles lie in pairs
    // in one plane.
    for (const char* const name : {"octahedron", "sphere:12x12", "icosphere:2", "sphere:20x20"}) {
        const Room room(*sample_mesh(name));
        const Vec3 middle = room.corner(room.mesh().positions().size() / 3);
        for (const std::uint64_t seed : {1U, 3U}) {
            const ClosedPath path = go_round(room, Loop(middle, 0.005, seed), 10000);
            expect_as_derived(path, std::string(name) + '_' + std::to_string(seed));
        }
    }
}

/// A pyramid of so many sides, almost flat.
TriangleMesh flat_pyramid(std::uint32_t sides, double height)
{
    std::vector<Vec3> positions = {Vec3(0, 0, height), Vec3(0, 0, -1)};
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides + 0.1;
        positions.emplace_back(std::cos(angle), std::sin(angle), 0);
        const std::uint32_t next = (i + 1) % sides;
        triangles.push_back({0, 2 + i, 2 + next});
        triangles.push_back({1, 2 + next, 2 + i});
    }
    return testing::mesh_of(std::move(positions), std::move(triangles));
}

TEST(ClosedPath, BetweenNearlyFlatWallsDissipatesWhatItsSeamsPredict)
{
    for (const double height : {0.5, 0.05, 0.005}) {
        const Room room(flat_pyramid(7, height));
        for (std::uint64_t seed = 1; seed <= 2; ++seed) {
            const ClosedPath path = go_round(room, Loop(room.corner(0), 0.005, seed), 10000);
            expect_as_derived(path,
                              "pyramid_" + std::to_string(height) + '_' + std::to_string(seed));
        }
    }
}

TEST(ClosedPath, DissipatesASixteenthAtFourTimesTheTicks)
{
    const Room room(*sample_mesh("sphere:12x12"));
    const Loop loop(room.corner(40), 0.005, 2);
    const ClosedPath coarse = go_round(room, loop, 8000);
    const ClosedPath fine = go_round(room, loop, 32000);
    expect_as_derived(coarse, "coarse");
    expect_as_derived(fine, "fine");
    // The same seams, but for those that a long step crosses two of.
    EXPECT_NEAR(fine.seams, coarse.seams, 0.1 * coarse.seams);
    EXPECT_LT(fine.most, 1.2 * coarse.most / 16);
    EXPECT_NEAR(fine.held, coarse.held / 4, 0.01 * std::abs(coarse.held));
}

/// The triangles that hold a proxy back, in the order in which it has them.
std::array<TriangleId, 3> holding(const RenderTick& felt)
{
    std::array<TriangleId, 3> ids;
    ids.fill(no_triangle);
    for (std::size_t i = 0; i < felt.contact_count; ++i) ids[i] = felt.contacts[i].triangle;
    std::ranges::sort(ids);
    return ids;
}

/// With the proxy at p, U = K / 2 |q - p|^2. Of a tick's way w in which the proxy moves by d,
///     trapezoid - dU = K / 2 (q before - p before + q - p) . d
/// which is nothing while the same faces hold it, for d lies in them; and as no slide ends farther
/// from q than it began, at least -K / 2 w . d where it comes to others.
TEST(ClosedPath, OverOuterEdgesNeverGeneratesEnergy)
{
    for (const char* const name : {"cube", "sphere:12x12"}) {
        const TriangleMesh mesh = *sample_mesh(name);
        for (const std::uint64_t seed : {1U, 2U, 4U}) { // whose loops go well into the models
            const Vec3 corner =
                Walk::map_of(mesh).to_device(mesh.positions()[seed % mesh.positions().size()]);
            const Loop loop(corner, 0.004, seed);
            constexpr int ticks = 10000;
            Walk walk(mesh, corner + 0.05 * corner.normalized(), loop.place(0, ticks));
            double taken = 0;
            double least = 0;
            double depth = 0;
            RenderTick last = walk.last();
            const auto stored = [](const RenderTick& felt) {
                return felt.force.squaredNorm() / (2 * stiffness);
            };
            const double stored_before = stored(last);
            for (int tick = 1; tick <= ticks; ++tick) {
                const RenderTick& felt = walk.go(loop.place(tick, ticks));
                const Vec3 way = felt.position - last.position;
                const Vec3 moved = way + (felt.force - last.force) / stiffness;
                if (holding(felt) != holding(last))
                    least -= stiffness / 2 * std::max(way.dot(moved), 0.0);
                least -= stiffness * rounding * way.norm();
                taken -= 0.5 * (felt.force + last.force).dot(way);
                depth = std::max(depth, felt.force.norm() / stiffness);
                last = felt;
            }
            EXPECT_GE(taken, stored(last) - stored_before + least) << name << seed;
            // Of drops over edges, where the force jumps within a tick: next to nothing.
            EXPECT_GT(depth, 0.002) << name << seed;
            EXPECT_GE(least, -2e-3 * stiffness * depth * depth) << name << seed;
        }
    }
}

} // namespace
} // namespace proxima::closed_path_test
