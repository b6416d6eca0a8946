// The answers to every question about some meshes, as one checksum each, held against answer_hashes.txt: the same bits on
// every instruction set, compiler, processor and number of threads.
//
// Where answers change on purpose, PROXIMA_WRITE_HASHES=1 has the test write the file anew.
#include "base/hash.h"
#include "base/simd.h"
#include "proxima/proxima.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace proxima::answer_hashes_test {
namespace {

/// A checksum of numbers one after the other; padding of structs does not count.
class Digest {
public:
    void add(std::uint64_t value)
    {
        hash_ = hash_bytes(std::as_bytes(std::span(&value, 1)), hash_);
    }
    void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
    void add(const Vec3& value)
    {
        for (const double coordinate : {value[0], value[1], value[2]}) add(coordinate);
    }
    void add(TriangleId id) { add(std::uint64_t{to_index(id)}); }
    void add(const Feature& feature)
    {
        add(static_cast<std::uint64_t>(feature.kind));
        add(std::uint64_t{feature.id});
    }
    void add(const ClosestFeature& closest)
    {
        add(closest.feature);
        add(closest.triangle);
        add(closest.point);
        for (const double weight : closest.barycentric) add(weight);
        add(closest.squared_distance);
    }
    void add(const RayHit& hit)
    {
        for (const double number : {hit.t, hit.u, hit.v}) add(number);
        add(hit.triangle);
    }

    [[nodiscard]] std::uint64_t value() const { return hash_; }

private:
    std::uint64_t hash_ = 0;
};

/// splitmix64: the standard library's distributions may differ from one library to the next.
class Numbers {
public:
    explicit Numbers(std::uint64_t seed) : state_(seed) {}

    double between(double low, double high)
    {
        return low + (high - low) * (static_cast<double>(next() >> 11U) * 0x1p-53);
    }
    Vec3 within(const Box& box)
    {
        const double x = between(box.lower[0], box.upper[0]);
        const double y = between(box.lower[1], box.upper[1]);
        const double z = between(box.lower[2], box.upper[2]);
        return {x, y, z};
    }

private:
    std::uint64_t next()
    {
        std::uint64_t z = state_ += 0x9E3779B97F4A7C15U;
        z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
        z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
        return z ^ (z >> 31U);
    }

    std::uint64_t state_;
};

/// The mesh's box, 1.25 times as large about its centre.
Box around(const TriangleMesh& mesh)
{
    const Box box = bounding_box(mesh);
    const Vec3 margin = 0.125 * box.extent();
    return {box.lower - margin, box.upper + margin};
}

std::uint64_t octree_digest(const TriangleMesh& mesh)
{
    Digest digest;
    const Octree octree = build_octree(mesh, {.max_depth = 7, .threshold = 4}).value();
    for (const OctreeNode& node : octree.nodes()) {
        digest.add(std::uint64_t{node.first});
        digest.add(std::uint64_t{node.packed});
    }
    for (const TriangleId id : octree.references()) digest.add(id);
    return digest.value();
}

std::uint64_t closest_digest(const MeshIndex& index, std::span<const Vec3> points)
{
    Digest digest;
    std::vector<ClosestFeature> answers(points.size());
    EXPECT_TRUE(closest_features(index, points, {.answers = answers}));
    for (const ClosestFeature& answer : answers) digest.add(answer);
    return digest.value();
}

std::uint64_t signed_digest(const MeshIndex& index, std::span<const Vec3> points)
{
    Digest digest;
    const MeshIndex with = with_signs(index).value();
    std::vector<SignedDistance> answers(points.size());
    EXPECT_TRUE(signed_distances(with, points, {.answers = answers}));
    for (const SignedDistance& answer : answers) {
        digest.add(answer.distance);
        digest.add(static_cast<std::uint64_t>(answer.method));
    }
    return digest.value();
}

std::uint64_t rays_digest(const MeshIndex& index, std::span<const Vec3> points)
{
    Digest digest;
    std::vector<Ray> rays;
    for (std::size_t i = 1; i < points.size(); i += 2)
        rays.push_back({.origin = points[i - 1], .direction = points[i] - points[i - 1]});
    std::vector<std::optional<RayHit>> hits(rays.size());
    EXPECT_TRUE(closest_hits(index, rays, hits));
    for (const std::optional<RayHit>& hit : hits) digest.add(hit.value_or(RayHit{.t = -1}));
    for (const Ray& ray : rays) {
        digest.add(std::uint64_t{any_hit(index, ray)});
        for (const RayHit& hit : all_hits(index, ray)) digest.add(hit);
    }
    return digest.value();
}

std::uint64_t visible_digest(const MeshIndex& index, const Box& box)
{
    Digest digest;
    const Vec3 extent = box.extent();
    for (const double share : {0.0, 0.4, 1.0}) {
        const ViewVolume volume =
            make_perspective_volume({.eye = box.lower + share * extent, .forward = {1, 0.5, 0.25}})
                .value();
        for (const CullMode mode : {CullMode::conservative, CullMode::exact}) {
            for (const TriangleId id : visible_triangles(index, volume, mode)) digest.add(id);
        }
    }
    return digest.value();
}

std::uint64_t meeting_digest(const MeshIndex& index, const Box& box)
{
    Digest digest;
    const Mat3 turn = (Mat3() << 0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6).finished();
    for (const double share : {0.1, 0.3, 3.0}) {
        const RigidTransform pose{turn, box.center() - turn * box.center() + share * box.extent()};
        for (const TrianglePair& pair : intersecting_pairs(index, index, pose)) {
            digest.add(pair.a);
            digest.add(pair.b);
        }
        for (const ContourPoint& point : intersection_contour(index, index, pose).points)
            digest.add(point.position);
        if (const std::optional<MeshDistance> apart = mesh_distance(index, index, pose)) {
            digest.add(apart->distance);
            digest.add(apart->point_a);
            digest.add(apart->triangle_b);
        }
    }
    return digest.value();
}

/// A device that is pressed into the mesh and drawn along it.
std::uint64_t touch_digest(const MeshIndex& index, const Box& box)
{
    Digest digest;
    const DeviceLimits limits;
    const WorkspaceMap map = fit_workspace(box, limits.workspace_radius);
    HapticRenderer renderer = make_haptic_renderer(index, map, limits).value();
    const Vec3 from = map.to_device(box.upper);
    const Vec3 to = map.to_device(box.center());
    for (int tick = 0; tick < 500; ++tick) {
        const double share = tick / 500.0;
        const Vec3 aside(0.02 * share * share, -0.01 * share, 0);
        const RenderTick& felt =
            renderer.tick({.pose = {Mat3::Identity(), from + share * (to - from) + aside}}, 1e-3);
        digest.add(felt.force);
        digest.add(felt.proxy);
    }
    return digest.value();
}

std::uint64_t minkowski_digest(const TriangleMesh& mesh, const Box& box)
{
    Digest digest;
    const ConvexPolyhedron hull = convex_hull(mesh.positions()).value();
    const ConvexPolyhedron cube = polyhedron_of_box({box.lower, box.center()}).value();
    const MinkowskiSum sum = minkowski_sum(hull, cube).value();
    Numbers numbers(5);
    for (int i = 0; i < 200; ++i) {
        const SurfacePoint nearest = signed_distance(sum, Vec3(3 * numbers.within(box)));
        digest.add(nearest.distance);
        digest.add(nearest.nearest);
    }
    return digest.value();
}

std::uint64_t field_digest(const MeshIndex& index, const Box& box)
{
    Digest digest;
    const PointGrid grid = grid_around(box, {.resolution = 24}).value();
    const std::size_t count = std::size_t{grid.size[0]} * grid.size[1] * grid.size[2];
    std::vector<double> distances(count);
    std::vector<Vec3> gradients(count);
    const MeshIndex with = with_signs(index).value();
    EXPECT_TRUE(distance_field(with, grid, {.distances = distances, .gradients = gradients}));
    for (const double distance : distances) digest.add(distance);
    for (const Vec3& gradient : gradients) digest.add(gradient);
    return digest.value();
}

std::uint64_t neighbours_digest(const MeshIndex& index, std::span<const Vec3> points,
                                const Box& box)
{
    Digest digest;
    std::array<NearTriangle, 7> nearest;
    std::vector<TriangleId> within(index.triangle_count());
    const auto add_all = [&](const Neighbourhood& found) {
        digest.add(std::uint64_t{found.written});
        for (std::size_t i = 0; i < found.written; ++i) digest.add(within[i]);
    };
    for (const Vec3& point : points.first(100)) {
        const std::size_t count = collect_nearest(index, point, nearest).written;
        for (std::size_t i = 0; i < count; ++i) {
            digest.add(nearest[i].squared_distance);
            digest.add(nearest[i].triangle);
        }
        add_all(collect_triangles(index, point, 0.3 * box.extent().x(), within));
        add_all(collect_triangles(index, Box{point, point + 0.2 * box.extent()}, within));
    }
    return digest.value();
}

/// The mesh from itself in another place.
std::uint64_t deviation_digest(const MeshIndex& index, const TriangleMesh& mesh, const Box& box)
{
    Digest digest;
    const Vec3 aside = Vec3(0.06, 0.02, -0.04).cwiseProduct(box.extent());
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    for (Vec3& position : positions) position += aside;
    const std::vector<TriangleCorners> triangles(mesh.triangles().begin(), mesh.triangles().end());
    const TriangleMesh moved = make_triangle_mesh(positions, triangles).value();
    const MeshIndex other = build_mesh_index(moved).value();
    const double tolerance = 0.01 * box.extent().x();
    const GreatestDeviation greatest =
        greatest_deviation(index, other, {.tolerance = tolerance}).value();
    digest.add(greatest.distance.lower);
    digest.add(greatest.distance.upper);
    digest.add(greatest.point_a);
    const MeanDeviation mean = mean_deviation(index, other, {.tolerance = tolerance}).value();
    for (const DistanceBounds& bounds : {mean.mean, mean.root_mean_square}) {
        digest.add(bounds.lower);
        digest.add(bounds.upper);
    }
    return digest.value();
}

/// Contact regions, depths and times of contact with the mesh itself in other places.
std::uint64_t physics_digest(const MeshIndex& index, const Box& box)
{
    Digest digest;
    const Solid solid = build_solid(index).value();
    const Mat3 turn = (Mat3() << 0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6).finished();
    for (const double share : {0.2, 0.5}) {
        const RigidTransform pose{turn, box.center() - turn * box.center() + share * box.extent()};
        const PenetrationDepth depth = penetration_depth(solid, solid, pose).value();
        for (const double bound : {depth.lower, depth.upper}) digest.add(bound);
        digest.add(depth.translation);
        const ContactRegions regions = contact_regions(solid, solid, pose).value();
        for (const ContactRegion& region : regions.regions) {
            digest.add(region.position);
            digest.add(region.normal);
            for (const double number : {region.depth, region.length, region.area})
                digest.add(number);
        }
        const RigidMotion motion{.start = {turn, 2 * box.extent()},
                                 .center = box.center(),
                                 .displacement = -2.1 * box.extent(),
                                 .turn = {share, 0.3, -0.2}};
        const std::optional<TimeOfContact> contact = time_of_contact(index, index, motion);
        digest.add(contact ? contact->free_until : -1);
        digest.add(contact ? contact->touches_at : -1);
    }
    return digest.value();
}

/// Some turned instances: rays, points and pairs.
std::uint64_t scene_digest(const MeshIndex& index, std::span<const Vec3> points, const Box& box)
{
    Digest digest;
    const Mat3 turn = (Mat3() << 0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6).finished();
    std::vector<Instance> instances;
    for (int i = 0; i < 40; ++i) {
        const Vec3 place = Vec3(i % 4, i / 4 % 4, i / 16).cwiseProduct(0.9 * box.extent());
        instances.push_back({.pose = {i % 3 == 0 ? Mat3(Mat3::Identity()) : turn, place}});
    }
    const Scene scene = build_scene(std::span(&index, 1), instances).value();
    for (std::size_t i = 1; i < points.size(); i += 2) {
        const Ray ray{.origin = 4 * points[i - 1], .direction = points[i] - points[i - 1]};
        for (const SceneHit& hit : all_hits(scene, ray)) {
            digest.add(std::uint64_t{to_index(hit.instance)});
            digest.add(hit.hit);
        }
        const SceneFeature near = closest_feature(scene, 4 * points[i]).value();
        digest.add(std::uint64_t{to_index(near.instance)});
        digest.add(near.closest);
        digest.add(near.distance);
    }
    const std::vector<InstancePair> pairs = pairs_in_contact(scene).value();
    for (const InstancePair& pair : pairs)
        digest.add(std::uint64_t{to_index(pair.a)} << 32U | to_index(pair.b));
    return digest.value();
}

/// One line for each mesh and question.
std::string all_hashes()
{
    std::ostringstream text;
    for (const char* const name : {"cube", "icosphere:3", "torus:24x12", "spaceship:1300"}) {
        const TriangleMesh mesh = sample_mesh(name).value();
        const Box box = around(mesh);
        Numbers numbers(20);
        std::vector<Vec3> points(1000);
        for (Vec3& point : points) point = numbers.within(box);
        const MeshIndex index = build_mesh_index(mesh).value();
        const auto line = [&](const char* question, std::uint64_t hash) {
            text << name << ' ' << question << ' ' << std::hex << std::setw(16) << std::setfill('0')
                 << hash << std::dec << '\n';
        };
        line("octree", octree_digest(mesh));
        line("closest", closest_digest(index, points));
        line("closest-lists", closest_digest(with_lists(index).value(), points));
        line("signed-distance", signed_digest(index, points));
        line("rays", rays_digest(index, points));
        line("rays-slabs", rays_digest(with_slabs(index).value(), points));
        line("visible", visible_digest(index, box));
        line("contact", meeting_digest(index, box));
        line("touch", touch_digest(index, box));
        line("minkowski", minkowski_digest(mesh, box));
        line("field", field_digest(index, box));
        line("neighbours", neighbours_digest(index, points, box));
        line("deviation", deviation_digest(index, mesh, box));
        line("physics", physics_digest(index, box));
        line("scene", scene_digest(index, points, box));
    }
    return text.str();
}

TEST(AnswerHashes, AreTheSameOnEveryInstructionSet)
{
    const std::string path = std::string(PROXIMA_SOURCE_DIR) + "/tests/lab/answer_hashes.txt";
    if (std::getenv("PROXIMA_WRITE_HASHES") != nullptr) std::ofstream(path) << all_hashes();
    std::ifstream file(path);
    const std::string expected((std::istreambuf_iterator<char>(file)),
                               std::istreambuf_iterator<char>());
    for (const SimdTarget& target : simd_targets()) {
        force_simd_target(target);
        EXPECT_EQ(all_hashes(), expected) << "on " << target.name;
        std::cout << "answers checked on " << target.name << '\n';
    }
    restore_simd_targets();
}

} // namespace
} // namespace proxima::answer_hashes_test
