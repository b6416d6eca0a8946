#include "query/deviation/surface_pair.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "query/closest/describe_closest.h"
#include "query/closest/find_closest.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

std::array<std::uint32_t, 3> vertices_of(const IndexParts& index, std::uint32_t row) noexcept
{
    const auto ids = [](const auto& of) {
        return std::array{of.vertices[0], of.vertices[1], of.vertices[2]};
    };
    return index.double_rows().empty() ? ids(index.float_rows()[row])
                                       : ids(index.double_rows()[row]);
}

Box box_of_rows(const IndexParts& index) noexcept
{
    Box box;
    for (std::uint32_t row = 0; row < index.triangle_count(); ++row) {
        for (const Vec3& vertex : index.triangle(row).vertices) box.extend(vertex);
    }
    return box;
}

double largest_coordinate(const Box& box) noexcept
{
    return std::max(box.lower.cwiseAbs().maxCoeff(), box.upper.cwiseAbs().maxCoeff());
}

Result<MeshIndex> scaled_index(const MeshIndex& index, int exponent, const Execution& execution,
                               bool& is_exact)
{
    const auto mesh = mesh_of(index);
    if (!mesh) return tl::unexpected(mesh.error());
    std::vector<Vec3> positions(mesh->positions().begin(), mesh->positions().end());
    for (Vec3& position : positions) {
        for (double& coordinate : position) {
            const double scaled = std::ldexp(coordinate, -exponent);
            // Vertices that no triangle uses may be anything.
            if (std::isfinite(coordinate) && std::ldexp(scaled, exponent) != coordinate)
                is_exact = false;
            coordinate = scaled;
        }
    }
    auto scaled = make_triangle_mesh(std::move(positions),
                                     {mesh->triangles().begin(), mesh->triangles().end()});
    if (!scaled) return tl::unexpected(scaled.error());
    return build_mesh_index(*scaled, {.execution = execution});
}

} // namespace

Result<SurfacePair> SurfacePair::make(const MeshIndex& a, const MeshIndex& b,
                                      const Execution& execution)
{
    for (const auto& [index, name] : {std::pair(&a, "a"), std::pair(&b, "b")}) {
        if (index->triangle_count() == 0) {
            return fail(ErrorCode::invalid_mesh,
                        "the mesh has no triangles: there is no distance from it or to it", name);
        }
    }
    if (Status status = check_budget(execution.budget, bytes_of(a), "measuring the deviation",
                                     "raise the budget or measure parts of the mesh");
        !status)
        return tl::unexpected(status.error());
    SurfacePair pair(a, b);
    if (Status status = pair.scale(execution); !status) return tl::unexpected(status.error());
    return pair;
}

std::uint64_t SurfacePair::bytes_of(const MeshIndex& a) noexcept
{
    constexpr std::uint64_t each_vertex = sizeof(NearestRow) + sizeof(Vec3) + sizeof(char);
    constexpr std::uint64_t each_triangle = sizeof(double) + sizeof(std::uint32_t);
    return each_vertex * a.vertex_count() + each_triangle * a.triangle_count();
}

Status SurfacePair::scale(const Execution& execution)
{
    measure();
    constexpr int usual = 60;
    int exponent = 0;
    (void)std::frexp(reach_, &exponent);
    if (reach_ == 0 || std::abs(exponent) <= usual) return {};
    exponent_ = exponent;
    for (MeshIndex* const index : {&a_, &b_}) {
        auto scaled = scaled_index(*index, exponent, execution, is_exact_);
        if (!scaled) return tl::unexpected(scaled.error());
        *index = *scaled;
    }
    measure();
    return {};
}

void SurfacePair::measure() noexcept
{
    Box box = box_of_rows(a());
    const Box other = box_of_rows(b());
    box.extend(other.lower);
    box.extend(other.upper);
    reach_ = largest_coordinate(box);
    diagonal_ = box.extent().norm();
}

double SurfacePair::to_units(double length) const noexcept
{
    return std::ldexp(length, -exponent_);
}

double SurfacePair::from_units(double length) const noexcept
{
    return std::ldexp(length, exponent_);
}

DistanceBounds SurfacePair::from_units(const DistanceBounds& bounds) const noexcept
{
    DistanceBounds result{from_units(bounds.lower), from_units(bounds.upper)};
    if (to_units(result.lower) > bounds.lower) result.lower = std::nextafter(result.lower, 0.0);
    if (to_units(result.upper) < bounds.upper)
        result.upper = std::nextafter(result.upper, HUGE_VAL);
    return result;
}

Vec3 SurfacePair::from_units(const Vec3& point) const noexcept
{
    return {from_units(point.x()), from_units(point.y()), from_units(point.z())};
}

double SurfacePair::area_from_units(double area) const noexcept
{
    return std::ldexp(area, 2 * exponent_);
}

double SurfacePair::area_error_from_units(double area, double error) const noexcept
{
    const auto back = [&](double converted) { return std::ldexp(converted, -2 * exponent_); };
    const double all = error + std::abs(back(area_from_units(area)) - area);
    const double result = area_from_units(all);
    return back(result) < all ? std::nextafter(result, HUGE_VAL) : result;
}

NearestRow SurfacePair::nearest(const Vec3& p, double known) const noexcept
{
    const double most = known * (1 + 0x1p-30) + rounding(64);
    const double scale = b().scale();
    RowDistance found = find_closest(b(), p, most);
    const double scaled = most * scale;
    if (!found.found() || !(found.squared <= scaled * scaled))
        found = find_closest(b(), p, std::numeric_limits<double>::infinity());
    // Seen from 2^511 times B's size away all of B is equally far, up to rounding.
    if (std::isinf(found.squared)) return {distance(p, found.rank), found.rank};
    return {std::sqrt(found.squared) * b().unscale(), found.rank};
}

Threads at_most(Threads threads, std::uint64_t most) noexcept
{
    const auto wanted = static_cast<std::uint64_t>(thread_count(threads));
    return {static_cast<int>(std::clamp<std::uint64_t>(most, 1, wanted))};
}

std::array<NearestRow, 3> MeasuredVertices::of_row(const IndexParts& a,
                                                   std::uint32_t row) const noexcept
{
    const auto [i, j, k] = vertices_of(a, row);
    return {nearest[i], nearest[j], nearest[k]};
}

Result<MeasuredVertices> measure_vertices(const SurfacePair& pair, const Execution& execution)
{
    const IndexParts& a = pair.a();
    std::vector<Vec3> positions(a.vertex_count());
    std::vector<char> is_used(a.vertex_count());
    for (std::uint32_t row = 0; row < a.triangle_count(); ++row) {
        const Triangle triangle = a.triangle(row);
        const auto vertices = vertices_of(a, row);
        for (std::size_t k = 0; k < 3; ++k) {
            positions[vertices[k]] = triangle.vertices[k];
            is_used[vertices[k]] = 1;
        }
    }
    MeasuredVertices vertices;
    vertices.nearest.resize(a.vertex_count());
    begin_stage(execution.progress, "distances of vertices", positions.size());
    constexpr std::size_t chunk = 1024;
    parallel_chunks(positions.size(), chunk, execution.threads,
                    [&](std::size_t first, std::size_t end) {
                        if (is_cancelled(execution.progress)) return;
                        constexpr double anywhere = std::numeric_limits<double>::infinity();
                        for (std::size_t i = first; i < end; ++i) {
                            if (is_used[i] != 0)
                                vertices.nearest[i] = pair.nearest(positions[i], anywhere);
                        }
                        advance_stage(execution.progress, end - first);
                    });
    if (is_cancelled(execution.progress)) return cancelled("measuring the deviation");
    return vertices;
}

} // namespace proxima
