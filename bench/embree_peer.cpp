#include "embree_peer.h"

#include "base/check.h"
#include "morton_order.h"
#include "triangle_distance.h"

#include <embree3/rtcore.h>

#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <vector>

namespace proxima::bench {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// How far a distance in float may be off, as a multiple of the largest coordinate M about the
/// centre, u = 2^-24. Rounding the query and the corner: 2 sqrt(3) u M. Rounding both sides: as
/// much. The nine differences and products of a distance, each at most 2 u M: 16 u M. Squares and
/// root: 3 u of a distance of at most 2 sqrt(3) M. That is 34 u M; where the distance is small,
/// the foot's place on the triangle may add as much again: thin triangles, where it would be more,
/// are measured in double.
constexpr double slack_per_extent = 0x1p-24 * 64;

/// Embree holds a node's boxes against the radius that a search began with, and only what it put
/// aside against the lower one of now. So a search that has met so many triangles is broken off
/// and begins anew with the radius found: up to a quarter off queries far from large meshes.
constexpr int triangles_before_restart = 24;

/// Corners and sides of all triangles about the centre, along a Morton curve, beside the same in
/// double. A thin triangle has a NaN among its sides, so that its distance is NaN.
struct Triangles {
    Triangles(const TriangleMesh& mesh, const Vec3& about, std::vector<TriangleId> order)
        : ids(std::move(order)), exact(mesh, ids)
    {
        quick.reserve(ids.size());
        boxes.reserve(ids.size());
        for (std::size_t i = 0; i < ids.size(); ++i) {
            const Triangle triangle = mesh.triangle(ids[i]);
            quick.push_back(sides_of<float>(triangle, about));
            if (exact.is_thin(i)) quick.back().ab[0] = std::numeric_limits<float>::quiet_NaN();
            Box box = bounding_box(triangle);
            boxes.push_back({box.lower - about, box.upper - about});
        }
    }

    std::vector<TriangleId> ids;
    ExactTriangles exact;
    std::vector<TriangleSides<float>> quick;
    std::vector<Box> boxes; ///< for the build only
};

/// One search: what came near so far.
struct Search {
    Search(const Triangles& among, const Vec3& from, const Vec3& place_of_point, double largest)
        : triangles(&among), point(&from), place{static_cast<float>(place_of_point.x()),
                                                 static_cast<float>(place_of_point.y()),
                                                 static_cast<float>(place_of_point.z())},
          slack(static_cast<float>(slack_per_extent * largest))
    {}

    const Triangles* triangles;
    const Vec3* point;
    std::array<float, 3> place; ///< the point about the centre
    float slack;
    float nearest = infinity;      ///< squared, of all triangles so far, in float
    float worth_a_look = infinity; ///< squared: beyond it a triangle cannot be closest
    PeerAnswer best;               ///< of the candidates measured so far

    struct Candidate {
        float squared_distance;
        std::uint32_t row;
    };
    int met = 0; ///< triangles
    bool broken_off = false;
    unsigned count = 0; ///< of candidates
    std::array<Candidate, 32> candidates;

    /// Where a triangle must be to matter. Embree's distances of boxes are rounded as well.
    [[nodiscard]] float radius() const { return std::sqrt(worth_a_look) + slack; }

    /// Notes a triangle at a distance. True where it is the nearest so far.
    bool note(std::uint32_t row, float squared)
    {
        if (count == candidates.size()) measure();
        candidates[count++] = {squared, row};
        if (squared >= nearest) return false;
        nearest = squared;
        const float reach = std::sqrt(squared) + 2 * slack;
        worth_a_look = reach * reach;
        return true;
    }

    /// Measures in double all candidates that can still be closest, and forgets them.
    void measure()
    {
        for (unsigned i = 0; i < count; ++i) {
            if (candidates[i].squared_distance > worth_a_look) continue;
            const std::uint32_t row = candidates[i].row;
            const double squared = triangles->exact.squared_distance(row, *point);
            if (squared < best.squared_distance) best = {squared, triangles->ids[row]};
        }
        count = 0;
    }
};

/// Called by Embree for every triangle that it reaches. True where it changed the radius.
bool consider(RTCPointQueryFunctionArguments* arguments)
{
    Search& search = *static_cast<Search*>(arguments->userPtr);
    const std::uint32_t row = arguments->primID;
    float squared = squared_distance(search.triangles->quick[row], search.place);
    if (std::isnan(squared)) {
        squared = static_cast<float>(search.triangles->exact.squared_distance(row, *search.point));
    }
    const bool nearer = squared <= search.worth_a_look && search.note(row, squared);
    if (nearer) arguments->query->radius = std::min(search.radius(), arguments->query->radius);
    if (++search.met != triangles_before_restart) return nearer;
    search.broken_off = true;
    arguments->query->radius = 0;
    return true;
}

void box_of_row(const RTCBoundsFunctionArguments* arguments)
{
    const auto& triangles = *static_cast<const Triangles*>(arguments->geometryUserPtr);
    const Box& box = triangles.boxes[arguments->primID];
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = static_cast<float>(box.lower.x());
    bounds.lower_y = static_cast<float>(box.lower.y());
    bounds.lower_z = static_cast<float>(box.lower.z());
    bounds.upper_x = static_cast<float>(box.upper.x());
    bounds.upper_y = static_cast<float>(box.upper.y());
    bounds.upper_z = static_cast<float>(box.upper.z());
}

bool count_memory(void* total, ssize_t bytes, bool /*after*/)
{
    *static_cast<std::atomic<std::ptrdiff_t>*>(total) += bytes;
    return true;
}

std::vector<TriangleId> along_curve(const TriangleMesh& mesh, const Box& box)
{
    std::vector<Vec3> middles;
    middles.reserve(mesh.triangle_count());
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i)
        middles.push_back(bounding_box(mesh.triangle(TriangleId{i})).center());
    std::vector<TriangleId> order;
    order.reserve(middles.size());
    for (const std::uint32_t i : morton_order(middles, box, most_order_bits))
        order.push_back(TriangleId{i});
    return order;
}

} // namespace

struct EmbreePeer::Built {
    Built(const TriangleMesh& mesh, FirstRadius how, const Box& box)
        : centre(box.center()), extent(0.5 * box.extent().maxCoeff()),
          triangles(mesh, centre, along_curve(mesh, box)), first(how),
          device(rtcNewDevice("threads=1"))
    {
        PROXIMA_CHECK(device != nullptr);
        rtcSetDeviceMemoryMonitorFunction(device, count_memory, &embree_bytes);
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
        auto* const geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles.ids.size()));
        rtcSetGeometryUserData(geometry, &triangles);
        rtcSetGeometryBoundsFunction(geometry, box_of_row, nullptr);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene);
        PROXIMA_CHECK_EQ(static_cast<int>(rtcGetDeviceError(device)), int{RTC_ERROR_NONE});
        triangles.boxes = {};
    }
    ~Built()
    {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
    Built(const Built&) = delete;
    Built& operator=(const Built&) = delete;

    Vec3 centre;
    double extent; ///< largest coordinate about the centre
    Triangles triangles;
    FirstRadius first;
    std::atomic<std::ptrdiff_t> embree_bytes = 0;
    RTCDevice device;
    RTCScene scene = nullptr;
    Vec3 last_point = Vec3::Zero();
    double last_distance = std::numeric_limits<double>::infinity();
};

EmbreePeer::EmbreePeer(const TriangleMesh& mesh, FirstRadius first)
    : built_(std::make_unique<Built>(mesh, first, bounding_box(mesh)))
{}

EmbreePeer::~EmbreePeer() = default;

PeerAnswer EmbreePeer::closest(const Vec3& point)
{
    Built& built = *built_;
    const Vec3 place = point - built.centre;
    const double extent = std::max(built.extent, place.cwiseAbs().maxCoeff());
    Search search(built.triangles, point, place, extent);
    RTCPointQuery query{search.place[0], search.place[1], search.place[2], 0, infinity};
    if (built.first == FirstRadius::warm) {
        const double bound = built.last_distance + (point - built.last_point).norm();
        query.radius = static_cast<float>(bound) + search.slack;
    }
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(built.scene, &query, &context, consider, &search);
    if (search.broken_off) {
        query.radius = search.radius();
        rtcPointQuery(built.scene, &query, &context, consider, &search);
    }
    search.measure();
    if (built.first == FirstRadius::warm) {
        built.last_point = point;
        built.last_distance = std::sqrt(search.best.squared_distance);
    }
    return search.best;
}

std::size_t EmbreePeer::bytes() const
{
    std::size_t sum = 0;
    for (const BytePart& part : byte_parts()) sum += part.bytes;
    return sum;
}

std::array<BytePart, 3> EmbreePeer::byte_parts() const
{
    const Triangles& triangles = built_->triangles;
    return {
        {{"Embree's own", static_cast<std::size_t>(built_->embree_bytes)},
         {"triangles in floats and their ids", triangles.quick.size() * sizeof(triangles.quick[0]) +
                                                   triangles.ids.size() * sizeof(triangles.ids[0])},
         {"triangles in doubles", triangles.exact.bytes()}}};
}

WarmEmbreePeer::WarmEmbreePeer(const TriangleMesh& mesh)
    : EmbreePeer(mesh, FirstRadius::warm), box_(bounding_box(mesh))
{}

void WarmEmbreePeer::closest(std::span<const Vec3> points, std::span<PeerAnswer> answers)
{
    if (pays_to_sort(points, box_)) {
        for (const std::uint32_t i : morton_order(points, box_, batch_order_bits))
            answers[i] = closest(points[i]);
    } else {
        for (std::size_t i = 0; i < points.size(); ++i) answers[i] = closest(points[i]);
    }
}

} // namespace proxima::bench
