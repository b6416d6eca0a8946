#include "proxima/signed_distance.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "mesh/surface_parts.h"
#include "proxima/mesh_index.h"
#include "query/batch_size.h"
#include "query/closest/sign_geometry.h"
#include "query/closest/sign_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t least_signs_per_task = 4096;
constexpr std::size_t most_signs_per_task = 65536;

/// A pseudonormal as the sum of unit normals may be off by this, in length.
constexpr double normal_error = 1e-10;
/// Distances are right to less than 2^-50 of themselves. A feature whose triangles are no flatter
/// than 2^-30 of the distance may be named for one so near to it that the direction to the point is
/// off by less than this.
constexpr double least_part = 0x1p-30;
constexpr double tie_error = 0x1p-18;
/// Nor does a face's foot tell that is nearer to its border than this: the face beyond it may be
/// as near.
constexpr double least_inset = 0x1p-40;

std::optional<bool> by_height(double height, double doubt) noexcept
{
    if (!(std::abs(height) > doubt)) return std::nullopt;
    return height < 0;
}

// Whether p is inside, told by a feature whose triangles separate; nothing in doubt.

/// On which side of the face's plane p is, exactly.
int side_of_face(const TriangleMesh& mesh, TriangleId face, const Vec3& p) noexcept
{
    const Triangle triangle = mesh.triangle(face);
    return orient3d(triangle[0], triangle[1], triangle[2], p);
}

/// Whether p is on the closest feature: as computed or exactly, though the closest point as
/// computed may be beside it.
bool is_on(const SignParts& sign, const ClosestFeature& closest, const Vec3& p,
           double distance) noexcept
{
    if (distance == 0) return true;
    constexpr double rounding = 0x1p-44;
    double size = p.cwiseAbs().maxCoeff();
    for (const Vec3& corner : sign.mesh().triangle(closest.triangle).vertices) {
        size = std::max(size, corner.cwiseAbs().maxCoeff());
    }
    if (distance > rounding * size) return false;
    if (closest.feature.kind == FeatureKind::face) {
        return side_of_face(sign.mesh(), closest.triangle, p) == 0;
    }
    if (closest.feature.kind == FeatureKind::vertex) return false;
    const EdgeVertices& ends = sign.topology().vertices(EdgeId{closest.feature.id});
    const Vec3& from = sign.mesh().position(ends[0]);
    return are_parallel({from, p}, {from, sign.mesh().position(ends[1])});
}

std::optional<bool> is_behind_edge(const SignParts& sign, EdgeId edge, const Vec3& p,
                                   double distance) noexcept
{
    const TriangleMesh& mesh = sign.mesh();
    Vec3 normal = Vec3::Zero();
    for (const TriangleId id : sign.topology().triangles(edge)) {
        if (!detail::is_proper(mesh.triangles()[to_index(id)])) continue;
        normal += unit_normal_of(mesh.triangle(id));
    }
    // The normal is across the edge, so any of its points will do: the nearer end rounds less.
    const EdgeVertices& ends = sign.topology().vertices(edge);
    const Vec3 from_low = p - mesh.position(ends[0]);
    const Vec3 from_high = p - mesh.position(ends[1]);
    const Vec3& from = from_low.squaredNorm() < from_high.squaredNorm() ? from_low : from_high;
    constexpr double rounding = 0x1p-48;
    return by_height(normal.dot(from), (normal_error + tie_error * normal.norm()) * distance +
                                           rounding * from.norm());
}

std::optional<bool> is_behind_vertex(const SignParts& sign, VertexId vertex, const Vec3& p,
                                     double distance) noexcept
{
    const Vec3& normal = sign.pseudonormals()[to_index(vertex)];
    return by_height(normal.dot(p - sign.mesh().position(vertex)),
                     (normal_error + tie_error) * distance);
}

SurfaceSides sides_of(const SignParts& sign, const Feature& feature) noexcept
{
    if (feature.kind == FeatureKind::vertex) return sign.vertex_sides()[feature.id];
    if (feature.kind == FeatureKind::face) return sign.sides()[feature.id];
    CommonSides common;
    for (const TriangleId id : sign.topology().triangles(EdgeId{feature.id})) {
        if (!detail::is_proper(sign.mesh().triangles()[to_index(id)])) continue;
        common.add(sign.sides()[to_index(id)]);
    }
    return common.result();
}

/// The least height of the triangles about a feature.
double height_at(const SignParts& sign, const Feature& feature) noexcept
{
    const auto least = [&](std::span<const TriangleId> triangles) {
        double height = std::numeric_limits<double>::infinity();
        for (const TriangleId id : triangles) {
            if (!detail::is_proper(sign.mesh().triangles()[to_index(id)])) continue;
            height = std::min(height, height_of(sign.mesh().triangle(id), sign.winding().unit()));
        }
        return height;
    };
    switch (feature.kind) {
    case FeatureKind::vertex:
        return least(sign.topology().triangles(VertexId{feature.id}));
    case FeatureKind::edge:
        return least(sign.topology().triangles(EdgeId{feature.id}));
    case FeatureKind::face:
        break;
    }
    return least(std::array{TriangleId{feature.id}});
}

/// Whether the feature is large enough, seen from its distance, to be told from its neighbours and
/// they from what lies behind them.
bool is_told_apart(const SignParts& sign, const ClosestFeature& closest, double distance) noexcept
{
    const auto large = [&](double height) {
        if (!(height > least_part * distance)) return false;
        return closest.feature.kind != FeatureKind::face ||
               *std::ranges::min_element(closest.barycentric) * height > least_inset * distance;
    };
    return large(sign.least_height()) || large(height_at(sign, closest.feature));
}

/// Whether p is inside by what the feature is known of; nothing in doubt.
std::optional<bool> is_inside_locally(const SignParts& sign, const ClosestFeature& closest,
                                      const Vec3& p, double distance) noexcept
{
    const Feature& feature = closest.feature;
    const SurfaceSides sides = sides_of(sign, feature);
    if (sides == SurfaceSides::doubtful || !is_told_apart(sign, closest, distance))
        return std::nullopt;
    switch (sides) {
    case SurfaceSides::inside_both:
        return true;
    case SurfaceSides::outside_both:
        return false;
    case SurfaceSides::doubtful:
        return std::nullopt;
    case SurfaceSides::separates:
        break;
    }
    switch (feature.kind) {
    case FeatureKind::vertex:
        return is_behind_vertex(sign, VertexId{feature.id}, p, distance);
    case FeatureKind::edge:
        return is_behind_edge(sign, EdgeId{feature.id}, p, distance);
    case FeatureKind::face:
        break;
    }
    const int side = side_of_face(sign.mesh(), TriangleId{feature.id}, p);
    return side == 0 ? std::nullopt : std::optional(side < 0);
}

} // namespace

SurfaceSign::SurfaceSign(std::shared_ptr<const SignParts> parts) noexcept : parts_(std::move(parts))
{}

bool SurfaceSign::is_local() const noexcept
{
    const auto sides = parts_->sides();
    return std::ranges::find(sides, SurfaceSides::doubtful) == sides.end();
}

std::uint64_t SurfaceSign::bytes() const noexcept
{
    return parts_->sides().size() + parts_->vertex_sides().size() +
           parts_->pseudonormals().size_bytes() + parts_->winding().clusters().size_bytes() +
           parts_->winding().order().size_bytes();
}

SignedDistance sign_of(const SurfaceSign& sign, const ClosestFeature& closest,
                       const Vec3& p) noexcept
{
    SignedDistance result{std::sqrt(closest.squared_distance), SignMethod::on_surface, closest};
    if (std::isnan(result.distance)) {
        result.method = SignMethod::none;
        return result;
    }
    const SignParts& parts = sign.parts();
    if (is_on(parts, closest, p, result.distance)) {
        result.distance = 0;
        return result;
    }
    const auto inside = is_inside_locally(parts, closest, p, result.distance);
    const bool beyond = !parts.bounds().contains(p);
    result.method =
        inside && !(beyond && *inside) ? SignMethod::pseudonormal : SignMethod::winding_number;
    if (beyond) return result;
    // Where squares overflow, whatever mesh there is is a dot.
    if (inside ? *inside : std::isfinite(result.distance) && is_inside(parts.winding(), p))
        result.distance = -result.distance;
    return result;
}

SignedDistance signed_distance(const MeshIndex& index, const SurfaceSign& sign,
                               const Vec3& p) noexcept
{
    return sign_of(sign, closest_feature(index, p).value_or(no_closest_feature()), p);
}

Status signed_distances(const MeshIndex& index, const SurfaceSign& sign,
                        std::span<const Vec3> points, const SignedOutputs& outputs,
                        const BatchOptions& options)
{
    for (const std::size_t size : {outputs.distances.size(), outputs.answers.size()}) {
        if (size == 0) continue;
        if (Status status = check_batch_size(size, points.size(), "points"); !status) return status;
    }
    const auto bad =
        std::ranges::find_if(points, [](const Vec3& point) { return !point.allFinite(); });
    if (bad != points.end()) {
        return fail(ErrorCode::invalid_argument,
                    concat("point ", bad - points.begin(), " is not finite: leave it out"),
                    "points");
    }
    const std::size_t share =
        points.size() / static_cast<std::size_t>(thread_count(options.execution.threads)) + 1;
    const std::size_t chunk = std::clamp(share, least_signs_per_task, most_signs_per_task);
    Progress* const progress = options.execution.progress;
    begin_stage(progress, "signed distances", points.size());
    parallel_for(
        (points.size() + chunk - 1) / chunk, options.execution.threads, [&](std::size_t i) {
            if (is_cancelled(progress)) return;
            const std::size_t first = i * chunk;
            const auto own = points.subspan(first, std::min(chunk, points.size() - first));
            std::vector<ClosestFeature> closest(own.size());
            // No errors: sizes agree and the points are finite.
            (void)closest_features(index, own, {.answers = closest},
                                   {.order = options.order, .execution = {.threads = {1}}});
            for (std::size_t k = 0; k < own.size(); ++k) {
                const SignedDistance answer = sign_of(sign, closest[k], own[k]);
                if (!outputs.distances.empty()) outputs.distances[first + k] = answer.distance;
                if (!outputs.answers.empty()) outputs.answers[first + k] = answer;
            }
            advance_stage(progress, own.size());
        });
    if (is_cancelled(progress))
        return fail(ErrorCode::cancelled, "signed distances: stopped on request");
    return {};
}

std::string_view name_of(SignMethod method) noexcept
{
    switch (method) {
    case SignMethod::on_surface:
        return "on_surface";
    case SignMethod::pseudonormal:
        return "pseudonormal";
    case SignMethod::winding_number:
        return "winding_number";
    case SignMethod::none:
        break;
    }
    return "none";
}

} // namespace proxima
