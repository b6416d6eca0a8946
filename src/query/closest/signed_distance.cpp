#include "query/closest/signed_distance.h"

#include "geometry/exact_predicates.h"
#include "index/build_mesh_index.h"
#include "mesh/surface_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace proxima {

namespace {

constexpr std::size_t vertices_per_task = 1024;

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
/// Shorter sums do not point anywhere: the surface folds back on itself.
constexpr double shortest_sum = 1e-6;

Vec3 unit_normal_of(const Triangle& triangle) noexcept
{
    return unit_normal({triangle[0], triangle[1]}, {triangle[0], triangle[2]});
}

/// The angle at the corner; 0 where a side has no length.
double angle_at(const Triangle& triangle, int corner) noexcept
{
    const Vec3 u = (triangle[(corner + 1) % 3] - triangle[corner]).stableNormalized();
    const Vec3 v = (triangle[(corner + 2) % 3] - triangle[corner]).stableNormalized();
    return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// What the sides of several triangles say together.
class CommonSides {
public:
    void add(SurfaceSides sides) noexcept
    {
        common_ = first_ || common_ == sides ? sides : SurfaceSides::doubtful;
        first_ = false;
    }
    [[nodiscard]] SurfaceSides result() const noexcept { return common_; }

private:
    SurfaceSides common_ = SurfaceSides::doubtful;
    bool first_ = true;
};

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
bool is_on(const SurfaceSign& sign, const ClosestFeature& closest, const Vec3& p,
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

std::optional<bool> is_behind_edge(const SurfaceSign& sign, EdgeId edge, const Vec3& p,
                                   double distance) noexcept
{
    const TriangleMesh& mesh = sign.mesh();
    Vec3 normal = Vec3::Zero();
    for (const TriangleId id : sign.topology().triangles(edge)) {
        if (!detail::is_proper(mesh.triangles()[index(id)])) continue;
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

std::optional<bool> is_behind_vertex(const SurfaceSign& sign, VertexId vertex, const Vec3& p,
                                     double distance) noexcept
{
    const Vec3& normal = sign.pseudonormals()[index(vertex)];
    return by_height(normal.dot(p - sign.mesh().position(vertex)),
                     (normal_error + tie_error) * distance);
}

SurfaceSides sides_of(const SurfaceSign& sign, const Feature& feature) noexcept
{
    if (feature.kind == FeatureKind::vertex) return sign.vertex_sides()[feature.id];
    if (feature.kind == FeatureKind::face) return sign.sides()[feature.id];
    CommonSides common;
    for (const TriangleId id : sign.topology().triangles(EdgeId{feature.id})) {
        if (!detail::is_proper(sign.mesh().triangles()[index(id)])) continue;
        common.add(sign.sides()[index(id)]);
    }
    return common.result();
}

/// The least height of a triangle; 0 where it has no area.
double height_of(const Triangle& triangle, double unit) noexcept
{
    const Vec3 a = (triangle[1] - triangle[0]) * unit;
    const Vec3 b = (triangle[2] - triangle[0]) * unit;
    const double longest =
        std::sqrt(std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()}));
    return longest > 0 ? a.cross(b).norm() / longest / unit : 0;
}

/// That of the triangles about a feature.
double height_at(const SurfaceSign& sign, const Feature& feature) noexcept
{
    const auto least = [&](std::span<const TriangleId> triangles) {
        double height = std::numeric_limits<double>::infinity();
        for (const TriangleId id : triangles) {
            if (!detail::is_proper(sign.mesh().triangles()[index(id)])) continue;
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
bool is_told_apart(const SurfaceSign& sign, const ClosestFeature& closest, double distance) noexcept
{
    const auto large = [&](double height) {
        if (!(height > least_part * distance)) return false;
        return closest.feature.kind != FeatureKind::face ||
               *std::ranges::min_element(closest.barycentric) * height > least_inset * distance;
    };
    return large(sign.least_height()) || large(height_at(sign, closest.feature));
}

/// Whether p is inside by what the feature is known of; nothing in doubt.
std::optional<bool> is_inside_locally(const SurfaceSign& sign, const ClosestFeature& closest,
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

// The steps of build_surface_sign.
class SurfaceSignBuilder {
public:
    SurfaceSignBuilder(const Topology& topology, WindingNumber winding,
                       std::vector<SurfaceSides> sides)
    {
        sign_.topology_ = &topology;
        sign_.winding_ = std::move(winding);
        sign_.sides_ = std::move(sides);
        const std::size_t vertices = sign_.mesh().vertex_count();
        sign_.vertex_sides_.assign(vertices, SurfaceSides::doubtful);
        const auto separate =
            std::ranges::find(sign_.sides_, SurfaceSides::separates) != sign_.sides_.end();
        if (separate) sign_.pseudonormals_.assign(vertices, Vec3::Zero());
    }

    /// Of the triangles that tell: where there are any, winding numbers are whole, and 0 outside of
    /// the mesh's box.
    void measure() noexcept
    {
        const TriangleMesh& mesh = sign_.mesh();
        constexpr double infinity = std::numeric_limits<double>::infinity();
        double least = infinity;
        for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
            if (sign_.sides_[i] == SurfaceSides::doubtful) continue;
            least =
                std::min(least, height_of(mesh.triangle(TriangleId{i}), sign_.winding().unit()));
        }
        sign_.least_height_ = least;
        sign_.bounds_ = least < infinity ? bounding_box(mesh)
                                         : Box{Vec3::Constant(-infinity), Vec3::Constant(infinity)};
    }

    void fill_vertices(Threads threads)
    {
        const std::size_t count = sign_.vertex_sides_.size();
        parallel_for((count + vertices_per_task - 1) / vertices_per_task, threads,
                     [&](std::size_t task) {
                         const std::size_t end = std::min(count, (task + 1) * vertices_per_task);
                         for (std::size_t i = task * vertices_per_task; i < end; ++i) {
                             fill_vertex(VertexId{static_cast<std::uint32_t>(i)});
                         }
                     });
    }

    [[nodiscard]] SurfaceSign result() noexcept { return std::move(sign_); }

private:
    void fill_vertex(VertexId vertex) noexcept
    {
        const TriangleMesh& mesh = sign_.mesh();
        CommonSides common;
        Vec3 sum = Vec3::Zero();
        for (const TriangleId id : sign_.topology_->triangles(vertex)) {
            const TriangleCorners& corners = mesh.triangles()[index(id)];
            if (!detail::is_proper(corners)) continue;
            common.add(sign_.sides_[index(id)]);
            if (common.result() != SurfaceSides::separates) continue;
            const auto corner =
                static_cast<int>(std::ranges::find(corners, index(vertex)) - corners.begin());
            const Triangle triangle = mesh.triangle(id);
            sum += angle_at(triangle, corner) * unit_normal_of(triangle);
        }
        SurfaceSides& sides = sign_.vertex_sides_[index(vertex)];
        sides = common.result();
        if (sides != SurfaceSides::separates) return;
        const double length = sum.norm();
        if (length < shortest_sum) {
            sides = SurfaceSides::doubtful;
        } else {
            sign_.pseudonormals_[index(vertex)] = sum / length;
        }
    }

    SurfaceSign sign_;
};

bool SurfaceSign::is_local() const noexcept
{
    return std::ranges::find(sides_, SurfaceSides::doubtful) == sides_.end();
}

std::uint64_t SurfaceSign::bytes() const noexcept
{
    return sides_.size() + vertex_sides_.size() + pseudonormals_.size() * sizeof(Vec3) +
           winding_.clusters().size_bytes() + winding_.order().size_bytes();
}

Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh, const Topology& topology,
                                       const MeshIndex& index, const SurfaceSignOptions& options)
{
    auto winding =
        build_winding_number(mesh, {.threads = options.threads, .progress = options.progress});
    if (!winding) return tl::unexpected(winding.error());
    auto sides = find_surface_sides(index, topology, *winding,
                                    {.threads = options.threads, .progress = options.progress});
    if (!sides) return tl::unexpected(sides.error());
    SurfaceSignBuilder builder(topology, std::move(*winding), std::move(*sides));
    builder.fill_vertices(options.threads);
    builder.measure();
    return builder.result();
}

Result<SurfaceSign> build_surface_sign(const TriangleMesh& mesh, const Topology& topology,
                                       const SurfaceSignOptions& options)
{
    const auto index =
        build_mesh_index(mesh, {.threads = options.threads, .progress = options.progress});
    if (!index) return tl::unexpected(index.error());
    return build_surface_sign(mesh, topology, *index, options);
}

SignedDistance sign_of(const SurfaceSign& sign, const ClosestFeature& closest,
                       const Vec3& p) noexcept
{
    SignedDistance result{std::sqrt(closest.squared_distance), SignMethod::on_surface, closest};
    if (std::isnan(result.distance)) {
        result.method = SignMethod::none;
        return result;
    }
    if (is_on(sign, closest, p, result.distance)) {
        result.distance = 0;
        return result;
    }
    const auto inside = is_inside_locally(sign, closest, p, result.distance);
    const bool beyond = !sign.bounds().contains(p);
    result.method =
        inside && !(beyond && *inside) ? SignMethod::pseudonormal : SignMethod::winding_number;
    if (beyond) return result;
    // Where squares overflow, whatever mesh there is is a dot.
    if (inside ? *inside : std::isfinite(result.distance) && is_inside(sign.winding(), p))
        result.distance = -result.distance;
    return result;
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
