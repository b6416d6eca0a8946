#include "distributed/mesh_slice.h"

#include "mesh/unit_circle.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace proxima {

namespace {

Status build_torus_slice(const TorusSize& size, const World& world, MeshSlice& slice)
{
    const std::uint64_t rows = size.across;
    slice.whole_triangles = 2 * rows * size.around;
    const Share share = share_of(slice.whole_triangles, world.rank(), world.size());
    if (share.end - share.first > max_slice_triangles) {
        return fail(ErrorCode::limit_exceeded,
                    "a rank would have more than 2^29 triangles: use more ranks");
    }
    slice.first_triangle = share.first;
    std::vector<WholeCorners> triangles;
    triangles.reserve(share.end - share.first);
    for (std::uint64_t id = share.first; id < share.end; ++id) {
        const std::uint64_t quad = id / 2;
        const std::uint64_t i = quad / rows;
        const std::uint64_t j = quad % rows;
        const std::uint64_t here = i * rows;
        const std::uint64_t next = (i + 1) % size.around * rows;
        const std::uint64_t up = (j + 1) % rows;
        triangles.push_back(id % 2 == 0 ? WholeCorners{here + j, next + j, next + up}
                                        : WholeCorners{here + j, next + up, here + up});
    }
    slice.vertices = used_vertices(triangles);
    std::vector<Vec3> positions;
    positions.reserve(slice.vertices.size());
    std::vector<CirclePoint> tube(size.across);
    for (std::uint32_t j = 0; j < size.across; ++j) tube[j] = unit_circle(j, size.across);
    for (const std::uint64_t vertex : slice.vertices) {
        const CirclePoint ring =
            // NOLINTNEXTLINE(clang-analyzer-core.DivideZero): a torus has at least three
            unit_circle(static_cast<std::uint32_t>(vertex / rows), size.around);
        const CirclePoint& point = tube[vertex % rows];
        const double radius = 1.0 + 0.5 * point.cosine;
        positions.emplace_back(radius * ring.cosine, radius * ring.sine, 0.5 * point.sine);
    }
    return assemble(triangles, std::move(positions), slice);
}

} // namespace

Share share_of(std::uint64_t count, int rank, int ranks) noexcept
{
    const auto n = static_cast<std::uint64_t>(ranks);
    const auto bound = [&](std::uint64_t r) { return count / n * r + count % n * r / n; };
    const auto r = static_cast<std::uint64_t>(rank);
    return {bound(r), bound(r + 1)};
}

std::optional<TorusSize> torus_size(std::string_view name) noexcept
{
    constexpr std::string_view start = "torus:";
    if (!name.starts_with(start)) return std::nullopt;
    name.remove_prefix(start.size());
    const char* const end = name.data() + name.size();
    TorusSize size;
    const auto one = std::from_chars(name.data(), end, size.around);
    if (one.ec != std::errc{} || one.ptr == end || *one.ptr != 'x') return std::nullopt;
    const auto other = std::from_chars(one.ptr + 1, end, size.across);
    if (other.ec != std::errc{} || other.ptr != end) return std::nullopt;
    constexpr std::uint32_t most = 1U << 30U;
    if (std::min(size.around, size.across) < 3 || std::max(size.around, size.across) > most) {
        return std::nullopt;
    }
    return size;
}

Result<MeshSlice> make_torus_slice(const TorusSize& size, World& world)
{
    MeshSlice slice;
    const Status status = world.agree_on([&] { return build_torus_slice(size, world, slice); });
    if (!status) return tl::unexpected(status.error());
    return slice;
}

namespace {

/// The range of numbers that corners use, where a mark for each of them costs less than a sort.
std::optional<Share> dense_range(const std::vector<WholeCorners>& triangles)
{
    Share range{std::numeric_limits<std::uint64_t>::max(), 0};
    for (const WholeCorners& corners : triangles) {
        for (const std::uint64_t corner : corners) {
            range.first = std::min(range.first, corner);
            range.end = std::max(range.end, corner + 1);
        }
    }
    if (triangles.empty() || range.end - range.first > 4 * triangles.size()) return std::nullopt;
    return range;
}

} // namespace

std::vector<std::uint64_t> used_vertices(const std::vector<WholeCorners>& triangles)
{
    std::vector<std::uint64_t> used;
    if (const auto range = dense_range(triangles)) {
        std::vector<bool> is_used(range->end - range->first);
        for (const WholeCorners& corners : triangles) {
            for (const std::uint64_t corner : corners) is_used[corner - range->first] = true;
        }
        for (std::uint64_t i = 0; i < is_used.size(); ++i) {
            if (is_used[i]) used.push_back(range->first + i);
        }
        used.shrink_to_fit();
        return used;
    }
    used.reserve(3 * triangles.size());
    for (const WholeCorners& corners : triangles) {
        used.insert(used.end(), corners.begin(), corners.end());
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    used.shrink_to_fit();
    return used;
}

Status assemble(const std::vector<WholeCorners>& triangles, std::vector<Vec3> positions,
                MeshSlice& slice)
{
    std::vector<std::uint32_t> numbers; // of a dense range of vertices
    const auto range = dense_range(triangles);
    if (range) {
        numbers.resize(range->end - range->first);
        for (std::uint32_t i = 0; i < slice.vertices.size(); ++i) {
            numbers[slice.vertices[i] - range->first] = i;
        }
    }
    const auto number_of = [&](std::uint64_t vertex) {
        if (range) return numbers[vertex - range->first];
        const auto at = std::ranges::lower_bound(slice.vertices, vertex);
        return static_cast<std::uint32_t>(at - slice.vertices.begin());
    };
    std::vector<TriangleCorners> local;
    local.reserve(triangles.size());
    for (const WholeCorners& corners : triangles) {
        local.push_back({number_of(corners[0]), number_of(corners[1]), number_of(corners[2])});
    }
    auto mesh = make_triangle_mesh(std::move(positions), std::move(local));
    if (!mesh) return tl::unexpected(mesh.error());
    slice.mesh = std::move(*mesh);
    return {};
}

} // namespace proxima
