// Triangles and features within balls and boxes, and the nearest so many, against a test of each alone.
#include "base/check.h"
#include "decoded_mesh.h"
#include "geometry/triangle_box.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"
#include "proxima/topology.h"
#include "query/closest/feature_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

using namespace proxima;

/// Squared distances of all triangles, in the order of answers, times the square of `scale.up`: in the
/// mesh's unit they may be too small for doubles, and all 0.
struct Truth {
    RowScale scale;
    std::vector<NearTriangle> scaled;
};

Truth triangles_one_by_one(const TriangleMesh& mesh, const Topology& topology, const Vec3& p)
{
    Truth truth{row_scale_of(mesh), {}};
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        NearestFeature nearest;
        offer_triangle(mesh, topology, TriangleId{i}, p, truth.scale, nearest);
        truth.scaled.push_back({nearest.squared, TriangleId{i}});
    }
    std::ranges::sort(truth.scaled, [](const auto& a, const auto& b) { return a < b; });
    return truth;
}

/// Some radius, or exactly the distance of a triangle, or hardly another one.
double decode_radius(fuzz::Bytes& bytes, const Truth& truth)
{
    const std::uint8_t form = bytes.next();
    const NearTriangle& one = truth.scaled[bytes.next() % truth.scaled.size()];
    const double near = std::sqrt(truth.scale.unscale_squared(one.squared_distance));
    switch (form % 4) {
    case 0:
        return near;
    case 1:
        return std::nextafter(near, HUGE_VAL);
    case 2:
        return std::nextafter(near, 0.0);
    default:
        return std::ldexp(near, form / 4 % 8 - 4);
    }
}

void expect_balls(const MeshIndex& index, const Vec3& p, double radius, const Truth& truth)
{
    // Squares that leave the doubles do not tell what is within.
    const double square = radius * radius;
    if (!(square == 0 || (square > 1e-280 && square < 1e280))) return;
    std::vector<NearTriangle> near = truth.scaled;
    const double limit = radius * truth.scale.up * (radius * truth.scale.up);
    std::erase_if(near, [&](const NearTriangle& one) { return one.squared_distance > limit; });
    for (NearTriangle& one : near)
        one.squared_distance = truth.scale.unscale_squared(one.squared_distance);
    std::vector<TriangleId> ids;
    ids.reserve(near.size());
    for (const NearTriangle& one : near) ids.push_back(one.triangle);
    std::ranges::sort(ids);

    const std::size_t count = truth.scaled.size();
    std::vector<TriangleId> found(count);
    const Neighbourhood within = collect_triangles(index, p, radius, found);
    PROXIMA_CHECK(within.complete);
    found.resize(within.written);
    PROXIMA_CHECK(found == ids);

    std::vector<NearTriangle> batch(2);
    std::vector<NearTriangle> visited;
    const auto visitor = [&](TriangleId id, double squared) {
        visited.push_back({squared, id});
        return Flow::proceed;
    };
    visit_nearest(index, p, batch, visitor, radius);
    PROXIMA_CHECK(visited == near);
    std::vector<NearTriangle> some(1 + count / 2);
    const Neighbourhood nearest = collect_nearest(index, p, some, radius);
    const std::size_t wanted = std::min(some.size(), near.size());
    PROXIMA_CHECK_EQ(nearest.written, wanted);
    PROXIMA_CHECK_EQ(nearest.complete, (near.size() < some.size() || count <= some.size()));
    PROXIMA_CHECK(
        std::equal(some.begin(), some.begin() + static_cast<long>(nearest.written), near.begin()));

    // Each triangle within has a feature within, and features are named once.
    std::vector<NearestFeature> features(8 * count);
    const Neighbourhood about = collect_features(index, p, radius, features);
    PROXIMA_CHECK(about.complete);
    features.resize(about.written);
    PROXIMA_CHECK_EQ(features.empty(), ids.empty());
    std::vector<TriangleId> faces;
    for (std::size_t i = 0; i < features.size(); ++i) {
        PROXIMA_CHECK_LE(features[i].squared, square);
        if (i > 0) PROXIMA_CHECK(features[i - 1].feature < features[i].feature);
        if (features[i].feature.kind == FeatureKind::face)
            faces.push_back(TriangleId{features[i].feature.id});
    }
    PROXIMA_CHECK(faces == ids);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code);
    const MeshIndex index = build_mesh_index(mesh, {.execution = {.threads = {1}}}).value();
    const Topology topology = build_topology(mesh).value();
    int questions = 0;
    do {
        const Vec3 p = fuzz::decode_point(bytes, code, mesh);
        const Truth truth = triangles_one_by_one(mesh, topology, p);
        expect_balls(index, p, decode_radius(bytes, truth), truth);

        const Vec3 q = fuzz::decode_point(bytes, code, mesh);
        const Box box = {p.cwiseMin(q), p.cwiseMax(q)};
        std::vector<TriangleId> inside;
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            if (triangle_overlaps_box(mesh.triangle(TriangleId{i}), box))
                inside.push_back(TriangleId{i});
        }
        std::vector<TriangleId> found(mesh.triangle_count());
        found.resize(collect_triangles(index, box, found).written);
        PROXIMA_CHECK(found == inside);
    } while (bytes.left() > 0 && ++questions < 4);
    return 0;
}
