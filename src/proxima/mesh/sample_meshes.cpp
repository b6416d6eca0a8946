#include "proxima/mesh/sample_meshes.h"

#include "proxima/base/check.h"
#include "proxima/base/memory_budget.h"
#include "proxima/base/text.h"
#include "proxima/mesh/topology.h"
#include "proxima/mesh/unit_circle.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace proxima {

namespace {

constexpr int max_icosphere_subdivisions = 11;

std::uint32_t id(std::size_t number) noexcept
{
    return static_cast<std::uint32_t>(number);
}

TriangleMesh checked(Result<TriangleMesh> mesh)
{
    PROXIMA_CHECK(mesh.has_value());
    return *std::move(mesh);
}

StageSteps making_mesh(Progress* progress, std::uint64_t triangles) noexcept
{
    return {progress, "making mesh", triangles};
}

tl::unexpected<Error> making_cancelled()
{
    return fail(ErrorCode::cancelled, "making the mesh was stopped on request");
}

// Explicit order of operations: the same bits whatever a vector library does.
Vec3 on_unit_sphere(const Vec3& point) noexcept
{
    const double squared = point.x() * point.x() + point.y() * point.y() + point.z() * point.z();
    return point / std::sqrt(squared);
}

// Every triangle into four; new vertices follow the old ones in the order of the edges.
Result<TriangleMesh> subdivided_sphere(const TriangleMesh& mesh, Progress* progress)
{
    const Result<Topology> topology = build_topology(mesh, {.threads = {1}, .progress = progress});
    if (is_cancelled(progress)) return making_cancelled();
    PROXIMA_CHECK(topology.has_value());
    StageSteps steps = making_mesh(progress, 4 * mesh.triangle_count());
    std::vector<Vec3> positions(mesh.positions().begin(), mesh.positions().end());
    positions.reserve(positions.size() + topology->edge_count());
    for (std::uint32_t edge = 0; edge < topology->edge_count(); ++edge) {
        const auto [low, high] = topology->vertices(EdgeId{edge});
        positions.push_back(on_unit_sphere(mesh.position(low) + mesh.position(high)));
        if (!steps.done(1)) return making_cancelled();
    }
    std::vector<TriangleCorners> triangles;
    triangles.reserve(4 * mesh.triangle_count());
    for (std::uint32_t triangle = 0; triangle < mesh.triangle_count(); ++triangle) {
        const TriangleCorners corner = mesh.triangles()[triangle];
        TriangleCorners middle{};
        for (std::size_t side = 0; side < 3; ++side) {
            const EdgeId edge = topology->edges(TriangleId{triangle})[side];
            middle[side] = id(mesh.vertex_count() + index(edge));
        }
        triangles.push_back({corner[0], middle[0], middle[2]});
        triangles.push_back({corner[1], middle[1], middle[0]});
        triangles.push_back({corner[2], middle[2], middle[1]});
        triangles.push_back(middle);
        if (!steps.done(3)) return making_cancelled(); // an edge and a half were the rest
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

Result<TriangleMesh> sphere(int stacks, int slices, Progress* progress)
{
    PROXIMA_CHECK_GE(stacks, 2);
    PROXIMA_CHECK_GE(slices, 3);
    const auto rings = static_cast<std::uint32_t>(stacks) - 1;
    const auto count = static_cast<std::uint32_t>(slices);
    StageSteps steps = making_mesh(progress, std::uint64_t{3} * rings * count);
    std::vector<CirclePoint> meridian(count);
    for (std::uint32_t j = 0; j < count; ++j) {
        meridian[j] = unit_circle(j, count);
        if (!steps.done(1)) return making_cancelled();
    }

    std::vector<Vec3> positions;
    positions.reserve(2 + std::size_t{rings} * count);
    positions.emplace_back(0.0, 0.0, 1.0);
    for (std::uint32_t i = 1; i <= rings; ++i) {
        const CirclePoint latitude = unit_circle(i, 2 * (rings + 1));
        for (const CirclePoint& along : meridian) {
            positions.emplace_back(on_circle_grid(latitude.sine * along.cosine),
                                   on_circle_grid(latitude.sine * along.sine), latitude.cosine);
            if (!steps.done(1)) return making_cancelled();
        }
    }
    positions.emplace_back(0.0, 0.0, -1.0);

    const std::uint32_t bottom = 1 + rings * count;
    const auto vertex = [&](std::uint32_t ring, std::uint32_t slice) {
        return 1 + (ring - 1) * count + slice % count;
    };
    std::vector<TriangleCorners> triangles;
    triangles.reserve(std::size_t{2} * rings * count);
    for (std::uint32_t j = 0; j < count; ++j) {
        triangles.push_back({0, vertex(1, j), vertex(1, j + 1)});
    }
    for (std::uint32_t i = 1; i < rings; ++i) {
        for (std::uint32_t j = 0; j < count; ++j) {
            const std::uint32_t start = vertex(i, j);
            const std::uint32_t end = vertex(i + 1, j + 1);
            triangles.push_back({start, vertex(i + 1, j), end});
            triangles.push_back({start, end, vertex(i, j + 1)});
            if (!steps.done(2)) return making_cancelled();
        }
    }
    for (std::uint32_t j = 0; j < count; ++j) {
        triangles.push_back({vertex(rings, j), bottom, vertex(rings, j + 1)});
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

Result<TriangleMesh> icosphere(int subdivisions, Progress* progress)
{
    PROXIMA_CHECK_GE(subdivisions, 0);
    PROXIMA_CHECK_LE(subdivisions, max_icosphere_subdivisions);
    const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
    // Vertices 4 a + 2 s + t: axis a is zero, the next +-1 (s), the one after +-golden (t).
    std::vector<Vec3> positions(12);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t signs = 0; signs < 4; ++signs) {
            Vec3 corner = Vec3::Zero();
            corner[static_cast<int>((axis + 1) % 3)] = signs / 2 == 0 ? 1.0 : -1.0;
            corner[static_cast<int>((axis + 2) % 3)] = signs % 2 == 0 ? golden : -golden;
            positions[4 * axis + signs] = on_unit_sphere(corner);
        }
    }
    std::vector<TriangleCorners> triangles;
    for (std::uint32_t s = 0; s < 2; ++s) {
        for (std::uint32_t t = 0; t < 2; ++t) {
            for (std::uint32_t axis = 0; axis < 3; ++axis) {
                // The short edge (-1, +1) of this axis, and the two vertices beside it.
                const std::uint32_t plus = 4 * axis + t;
                const std::uint32_t minus = plus + 2;
                const std::uint32_t beside = 4 * ((axis + 1) % 3) + 2 * t + s;
                if (s == t) {
                    triangles.push_back({plus, minus, beside});
                } else {
                    triangles.push_back({minus, plus, beside});
                }
            }
            for (std::uint32_t u = 0; u < 2; ++u) {
                // One vertex of each axis, all three towards the octant of signs s, t, u.
                const TriangleCorners octant = {2 * t + u, 4 + 2 * u + s, 8 + 2 * s + t};
                triangles.push_back((s + t + u) % 2 == 0
                                        ? octant
                                        : TriangleCorners{octant[0], octant[2], octant[1]});
            }
        }
    }
    auto mesh = make_triangle_mesh(std::move(positions), std::move(triangles));
    for (int level = 0; level < subdivisions && mesh; ++level) {
        mesh = subdivided_sphere(*mesh, progress);
    }
    return mesh;
}

Result<TriangleMesh> torus(int around, int across, Progress* progress)
{
    PROXIMA_CHECK_GE(around, 3);
    PROXIMA_CHECK_GE(across, 3);
    const auto columns = static_cast<std::uint32_t>(around);
    const auto rows = static_cast<std::uint32_t>(across);
    StageSteps steps = making_mesh(progress, std::uint64_t{2} * columns * rows);
    std::vector<CirclePoint> tube(rows);
    for (std::uint32_t j = 0; j < rows; ++j) {
        tube[j] = unit_circle(j, rows);
        if (!steps.done(1)) return making_cancelled();
    }

    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;
    positions.reserve(std::size_t{columns} * rows);
    triangles.reserve(std::size_t{2} * columns * rows);
    for (std::uint32_t i = 0; i < columns; ++i) {
        const CirclePoint ring = unit_circle(i, columns);
        const std::uint32_t here = i * rows;
        const std::uint32_t next = (i + 1) % columns * rows;
        for (std::uint32_t j = 0; j < rows; ++j) {
            const double radius = 1.0 + 0.5 * tube[j].cosine;
            positions.emplace_back(radius * ring.cosine, radius * ring.sine, 0.5 * tube[j].sine);
            const std::uint32_t up = (j + 1) % rows;
            triangles.push_back({here + j, next + j, next + up});
            triangles.push_back({here + j, next + up, here + up});
            if (!steps.done(2)) return making_cancelled();
        }
    }
    return make_triangle_mesh(std::move(positions), std::move(triangles));
}

// The part of `name` behind its first colon; nothing where there is no colon.
std::optional<std::string_view> size_text(std::string_view name) noexcept
{
    const std::size_t colon = name.find(':');
    if (colon == std::string_view::npos) return std::nullopt;
    return name.substr(colon + 1);
}

std::optional<std::uint64_t> parse_number(std::string_view text) noexcept
{
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool whole = error == std::errc{} && end == text.data() + text.size();
    return whole ? std::optional(number) : std::nullopt;
}

struct TwoNumbers {
    std::uint64_t first = 0;
    std::uint64_t second = 0;
};

std::optional<TwoNumbers> parse_two_numbers(std::string_view text) noexcept
{
    const std::size_t cross = text.find('x');
    if (cross == std::string_view::npos) return std::nullopt;
    const auto first = parse_number(text.substr(0, cross));
    const auto second = parse_number(text.substr(cross + 1));
    if (!first || !second) return std::nullopt;
    return TwoNumbers{*first, *second};
}

tl::unexpected<Error> bad_size(std::string_view name, std::string_view allowed)
{
    return fail(ErrorCode::invalid_argument, concat("a bad size; write ", allowed),
                std::string(name));
}

// Refuses sizes past the limit and meshes (with scratch) that memory cannot hold.
// A size that overflows arrives as the largest number.
Status check_size(std::string_view name, std::uint64_t triangles, std::uint64_t bytes_each)
{
    if (triangles > max_sample_triangles) {
        return fail(ErrorCode::limit_exceeded,
                    concat("a built-in mesh has at most ", max_sample_triangles,
                           " triangles: ask for a smaller one"),
                    std::string(name));
    }
    return check_budget({}, triangles * bytes_each, name, "ask for a smaller mesh");
}

std::uint64_t saturated_product(std::uint64_t a, std::uint64_t b) noexcept
{
    constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
    return b != 0 && a > most / b ? most : a * b;
}

// A vertex per two triangles, and the growth of nothing: arrays are reserved.
constexpr std::uint64_t grid_bytes = sizeof(TriangleCorners) + sizeof(Vec3) / 2;
// The topology of the last but one level comes on top.
constexpr std::uint64_t icosphere_bytes = 2 * grid_bytes;
// Faces, their queue, and the arrays as they grow.
constexpr std::uint64_t spaceship_bytes = 4 * grid_bytes;

Result<TriangleMesh> sized_sphere(std::string_view name, const SampleOptions& options)
{
    const auto size = parse_two_numbers(size_text(name).value_or(""));
    if (!size || size->first < 2 || size->second < 3) {
        return bad_size(name, "sphere:STACKSxSLICES with at least 2 stacks and 3 slices, such as "
                              "sphere:100x100");
    }
    const std::uint64_t pairs = saturated_product(size->first - 1, size->second);
    const Status fits = check_size(name, saturated_product(pairs, 2), grid_bytes);
    if (!fits) return tl::unexpected(fits.error());
    return sphere(static_cast<int>(size->first), static_cast<int>(size->second), options.progress);
}

Result<TriangleMesh> sized_icosphere(std::string_view name, const SampleOptions& options)
{
    const auto size = parse_number(size_text(name).value_or(""));
    if (!size || *size > max_icosphere_subdivisions) {
        return bad_size(name, concat("icosphere:N with N from 0 (20 triangles) to ",
                                     max_icosphere_subdivisions, " (four times as many each)"));
    }
    const Status fits = check_size(name, std::uint64_t{20} << (2 * *size), icosphere_bytes);
    if (!fits) return tl::unexpected(fits.error());
    return icosphere(static_cast<int>(*size), options.progress);
}

Result<TriangleMesh> sized_torus(std::string_view name, const SampleOptions& options)
{
    const auto size = parse_two_numbers(size_text(name).value_or(""));
    if (!size || size->first < 3 || size->second < 3) {
        return bad_size(name, "torus:NxM with at least 3 quads round the ring and 3 round the "
                              "tube, such as torus:60x30");
    }
    const std::uint64_t quads = saturated_product(size->first, size->second);
    const Status fits = check_size(name, saturated_product(quads, 2), grid_bytes);
    if (!fits) return tl::unexpected(fits.error());
    return torus(static_cast<int>(size->first), static_cast<int>(size->second), options.progress);
}

Result<TriangleMesh> sized_spaceship(std::string_view name, const SampleOptions& options)
{
    const auto size = parse_number(size_text(name).value_or(""));
    if (!size) {
        return bad_size(name, concat("spaceship:TRIANGLES with an even number from ",
                                     min_spaceship_triangles, ", such as spaceship:33000"));
    }
    const Status fits = check_size(name, *size, spaceship_bytes);
    if (!fits) return tl::unexpected(fits.error());
    return make_spaceship(static_cast<std::size_t>(*size), options);
}

Result<TriangleMesh> unsized_cube(std::string_view name, const SampleOptions& /*options*/)
{
    if (size_text(name)) return bad_size(name, "cube alone: it has no size");
    return make_cube();
}

Result<TriangleMesh> unsized_octahedron(std::string_view name, const SampleOptions& /*options*/)
{
    if (size_text(name)) return bad_size(name, "octahedron alone: it has no size");
    return make_octahedron();
}

struct SampleKind {
    std::string_view word;
    Result<TriangleMesh> (*make)(std::string_view name, const SampleOptions& options);
};

constexpr std::array<SampleKind, 6> sample_kinds = {{{"sphere", sized_sphere},
                                                     {"icosphere", sized_icosphere},
                                                     {"cube", unsized_cube},
                                                     {"octahedron", unsized_octahedron},
                                                     {"torus", sized_torus},
                                                     {"spaceship", sized_spaceship}}};

const SampleKind* find_kind(std::string_view name) noexcept
{
    const std::string_view word = name.substr(0, name.find(':'));
    const auto* kind = std::find_if(sample_kinds.begin(), sample_kinds.end(),
                                    [&](const SampleKind& each) { return each.word == word; });
    return kind == sample_kinds.end() ? nullptr : kind;
}

} // namespace

bool is_sample_mesh_name(std::string_view name) noexcept
{
    return find_kind(name) != nullptr;
}

std::string_view sample_mesh_names() noexcept
{
    return "sphere:STACKSxSLICES, icosphere:N, cube, octahedron, torus:NxM, spaceship:TRIANGLES";
}

Result<TriangleMesh> sample_mesh(std::string_view name, const SampleOptions& options)
{
    const SampleKind* kind = find_kind(name);
    if (kind == nullptr) {
        return fail(ErrorCode::invalid_argument,
                    concat("no built-in mesh has this name; there are ", sample_mesh_names()),
                    std::string(name));
    }
    return kind->make(name, options);
}

TriangleMesh make_sphere(int stacks, int slices)
{
    return checked(sphere(stacks, slices, nullptr));
}

TriangleMesh make_icosphere(int subdivisions)
{
    return checked(icosphere(subdivisions, nullptr));
}

TriangleMesh make_torus(int around, int across)
{
    return checked(torus(around, across, nullptr));
}

TriangleMesh make_cube()
{
    std::vector<Vec3> positions;
    for (unsigned corner = 0; corner < 8; ++corner) {
        positions.emplace_back((corner & 1U) != 0 ? 1.0 : -1.0, (corner & 2U) != 0 ? 1.0 : -1.0,
                               (corner & 4U) != 0 ? 1.0 : -1.0);
    }
    return checked(make_triangle_mesh(std::move(positions), {{0, 2, 3},
                                                             {0, 3, 1},
                                                             {4, 5, 7},
                                                             {4, 7, 6},
                                                             {0, 1, 5},
                                                             {0, 5, 4},
                                                             {2, 6, 7},
                                                             {2, 7, 3},
                                                             {0, 4, 6},
                                                             {0, 6, 2},
                                                             {1, 3, 7},
                                                             {1, 7, 5}}));
}

TriangleMesh make_octahedron()
{
    std::vector<Vec3> positions = {Vec3(1, 0, 0),  Vec3(-1, 0, 0), Vec3(0, 1, 0),
                                   Vec3(0, -1, 0), Vec3(0, 0, 1),  Vec3(0, 0, -1)};
    return checked(make_triangle_mesh(
        std::move(positions),
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}));
}

} // namespace proxima
