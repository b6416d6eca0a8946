#include "minkowski/export_sum.h"

#include "base/file_extension.h"
#include "base/output_file.h"
#include "base/text.h"
#include "mesh/io/glb_file.h"
#include "minkowski/drawn_surface.h"

#include <algorithm>
#include <string>
#include <vector>

namespace proxima {
namespace {

constexpr std::array origins = {FacetOrigin::a, FacetOrigin::b, FacetOrigin::both,
                                FacetOrigin::swept};

Status write_text(const std::string& text, const std::filesystem::path& path, Progress* progress)
{
    auto file = OutputFile::create(path, {progress, text.size()});
    if (!file) return tl::unexpected(file.error());
    if (Status status = file->write(text); !status) return status;
    return file->commit();
}

std::string obj_text(const MinkowskiSum& sum, const DrawnSurface& surface)
{
    std::string text = "# Minkowski sum: groups by the origin of the facets\n";
    for (const Vec3& p : surface.positions)
        text += concat("v ", p.x(), " ", p.y(), " ", p.z(), "\n");
    for (const FacetOrigin origin : origins) {
        bool is_first = true;
        for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
            if (sum.facet(f).origin != origin) continue;
            if (is_first) text += concat("g ", name_of(origin), "\nusemtl ", name_of(origin), "\n");
            is_first = false;
            text += 'f';
            for (const std::uint32_t corner : surface.polygon(f)) text += concat(" ", corner + 1);
            text += '\n';
        }
    }
    return text;
}

std::string ply_text(const MinkowskiSum& sum, const DrawnSurface& surface)
{
    std::string text =
        concat("ply\nformat ascii 1.0\ncomment Minkowski sum: red of A, blue of B, purple of both, "
               "green swept\nelement vertex ",
               surface.positions.size(),
               "\nproperty double x\nproperty double y\nproperty double z\nelement face ",
               surface.polygon_count(),
               "\nproperty list int int vertex_indices\nproperty uchar red\nproperty uchar green\n"
               "property uchar blue\nend_header\n");
    for (const Vec3& p : surface.positions) text += concat(p.x(), " ", p.y(), " ", p.z(), "\n");
    for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
        text += to_text(surface.polygon(f).size());
        for (const std::uint32_t corner : surface.polygon(f)) text += concat(" ", corner);
        for (const std::uint8_t part : colour_of(sum.facet(f).origin))
            text += concat(" ", static_cast<int>(part));
        text += '\n';
    }
    return text;
}

Status export_glb(const MinkowskiSum& sum, const DrawnSurface& surface,
                  const std::filesystem::path& path, Progress* progress)
{
    const Vec3 origin_point = surface.positions[0];
    std::vector<GlbPart> parts;
    for (const FacetOrigin origin : origins) {
        GlbPart part;
        part.name = name_of(origin);
        for (std::size_t i = 0; i < 3; ++i) part.colour[i] = colour_of(origin)[i] / 255.0;
        for (std::uint32_t f = 0; f < sum.facet_count(); ++f) {
            if (sum.facet(f).origin != origin) continue;
            // Each facet has its own corners, so that viewers shade it flat.
            const auto polygon = surface.polygon(f);
            const auto first = static_cast<std::uint32_t>(part.points.size());
            for (const std::uint32_t corner : polygon)
                part.add_point(surface.positions[corner], origin_point);
            for (std::uint32_t i = 2; i < polygon.size(); ++i)
                part.indices.insert(part.indices.end(), {first, first + i - 1, first + i});
        }
        parts.push_back(std::move(part));
    }
    return write_glb(parts, origin_point, path, progress);
}

} // namespace

std::string_view name_of(FacetOrigin origin) noexcept
{
    switch (origin) {
    case FacetOrigin::a:
        return "a";
    case FacetOrigin::b:
        return "b";
    case FacetOrigin::both:
        return "both";
    case FacetOrigin::swept:
        break;
    }
    return "swept";
}

std::array<std::uint8_t, 3> colour_of(FacetOrigin origin) noexcept
{
    switch (origin) {
    case FacetOrigin::a:
        return {200, 60, 50};
    case FacetOrigin::b:
        return {60, 90, 200};
    case FacetOrigin::both:
        return {150, 70, 170};
    case FacetOrigin::swept:
        break;
    }
    return {70, 170, 80};
}

Status check_sum_format(const std::filesystem::path& path)
{
    const std::string extension = lower_case_extension(path);
    if (extension == ".obj" || extension == ".ply" || extension == ".glb") return {};
    return fail(ErrorCode::unsupported_format,
                concat("a sum cannot be written as \"", extension, "\": use .obj, .ply or .glb"),
                path.string());
}

Status export_sum(const MinkowskiSum& sum, const std::filesystem::path& path,
                  const SumExportOptions& options)
{
    if (Status status = check_sum_format(path); !status) return status;
    const auto surface = draw(sum, options.ray_length);
    if (!surface) return tl::unexpected(surface.error());
    const std::string extension = lower_case_extension(path);
    if (extension == ".obj")
        return write_text(obj_text(sum, *surface), path, options.execution.progress);
    if (extension == ".ply")
        return write_text(ply_text(sum, *surface), path, options.execution.progress);
    return export_glb(sum, *surface, path, options.execution.progress);
}

} // namespace proxima
