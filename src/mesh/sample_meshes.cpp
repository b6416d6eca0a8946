#include "proxima/sample_meshes.h"

#include "base/memory_budget.h"
#include "base/text.h"
#include "mesh/sample_shapes.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

namespace proxima {

namespace {

using detail::icosphere;
using detail::max_icosphere_subdivisions;
using detail::sphere;
using detail::torus;

// The part of `name` after its first colon; nothing where there is no colon.
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

// A vertex per two triangles. Arrays are reserved and do not grow.
constexpr std::uint64_t grid_bytes = sizeof(TriangleCorners) + sizeof(Vec3) / 2;
// The topology of the last but one level is in memory too.
constexpr std::uint64_t icosphere_bytes = 2 * grid_bytes;
// Faces, their queue, and the growing arrays.
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
    return sphere(static_cast<int>(size->first), static_cast<int>(size->second),
                  options.execution.progress);
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
    return icosphere(static_cast<int>(*size), options.execution.progress);
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
    return torus(static_cast<int>(size->first), static_cast<int>(size->second),
                 options.execution.progress);
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

} // namespace proxima
