// Binary glTF 2.0: 12 bytes of header, a JSON chunk, and one buffer of
//
//     mesh positions | mesh indices | corners of boundary leaves | their edges, as lines
//
// Numbers are little-endian floats and 32-bit integers, so every part is aligned to 4.
#include "proxima/base/output_file.h"
#include "proxima/base/text.h"
#include "proxima/octree/export.h"
#include "proxima/octree/leaf_boxes.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian");

constexpr std::uint32_t glb_magic = 0x46546C67;  // "glTF"
constexpr std::uint32_t json_chunk = 0x4E4F534A; // "JSON"
constexpr std::uint32_t binary_chunk = 0x004E4942;
constexpr int float_type = 5126;
constexpr int index_type = 5125;

/// Pairs of corners that an edge joins.
constexpr std::array<std::uint8_t, 24> edges = {0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3,
                                                4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7};

using FloatPoint = std::array<float, 3>;

/// Positions relative to `origin` and what indexes them, with their range.
struct Geometry {
    std::vector<FloatPoint> points;
    std::vector<std::uint32_t> indices;
    FloatPoint lower{};
    FloatPoint upper{};
    bool finite = true;

    void add_point(const Vec3& point, const Vec3& origin)
    {
        FloatPoint single{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<Eigen::Index>(axis);
            single[axis] = static_cast<float>(point[i] - origin[i]);
            finite = finite && std::isfinite(single[axis]);
            lower[axis] = points.empty() ? single[axis] : std::min(lower[axis], single[axis]);
            upper[axis] = points.empty() ? single[axis] : std::max(upper[axis], single[axis]);
        }
        points.push_back(single);
    }
};

/// The mesh's vertices that triangles use, in order of first use.
Result<Geometry> mesh_geometry(const TriangleMesh& mesh, const Vec3& origin, Progress* progress)
{
    StageSteps steps(progress, "collecting triangles", mesh.triangle_count());
    constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(mesh.vertex_count(), unused);
    Geometry geometry;
    for (const TriangleCorners& corners : mesh.triangles()) {
        for (const std::uint32_t corner : corners) {
            if (number[corner] == unused) {
                number[corner] = static_cast<std::uint32_t>(geometry.points.size());
                geometry.add_point(mesh.positions()[corner], origin);
            }
            geometry.indices.push_back(number[corner]);
        }
        if (!steps.done(1)) return export_cancelled();
    }
    return geometry;
}

Result<Geometry> box_geometry(const Octree& octree, const Vec3& origin, Progress* progress)
{
    const auto leaves = leaf_boxes(octree, LeafChoice::boundary, progress);
    if (!leaves) return tl::unexpected(leaves.error());
    const auto corners = LeafCorners::find(*leaves, progress);
    if (!corners) return tl::unexpected(corners.error());
    StageSteps steps(progress, "arranging boxes", corners->size() + 24 * leaves->size());
    Geometry geometry;
    for (std::size_t i = 0; i < corners->size(); ++i) {
        geometry.add_point(corners->position(octree, i), origin);
        if (!steps.done(1)) return export_cancelled();
    }
    for (const LeafBox& leaf : *leaves) {
        for (const std::uint8_t corner : edges) {
            geometry.indices.push_back(static_cast<std::uint32_t>(corners->number(leaf, corner)));
        }
        if (!steps.done(24)) return export_cancelled();
    }
    return geometry;
}

std::string triple(const std::array<float, 3>& values)
{
    return concat("[", values[0], ",", values[1], ",", values[2], "]");
}

/// Writes the JSON objects of one geometry after another.
class Document {
public:
    void add(const Geometry& geometry, const char* name, int mode, const char* colour,
             const Vec3& origin)
    {
        const std::uint64_t points = std::span(geometry.points).size_bytes();
        const std::uint64_t indices = std::span(geometry.indices).size_bytes();
        const char* const comma = count_ == 0 ? "" : ",";
        nodes_ += concat(comma, R"({"name":")", name, R"(","mesh":)", count_, R"(,"translation":[)",
                         origin[0], ",", origin[1], ",", origin[2], "]}");
        scene_ += concat(comma, count_);
        meshes_ +=
            concat(comma, R"({"name":")", name, R"(","primitives":[{"attributes":{"POSITION":)",
                   2 * count_, R"(},"indices":)", 2 * count_ + 1, R"(,"mode":)", mode,
                   R"(,"material":)", count_, "}]}");
        materials_ += concat(comma, R"({"name":")", name,
                             R"(","doubleSided":true,"pbrMetallicRoughness":{)"
                             R"("baseColorFactor":)",
                             colour, R"(,"metallicFactor":0,"roughnessFactor":0.8}})");
        accessors_ +=
            concat(comma, R"({"bufferView":)", 2 * count_, R"(,"componentType":)", float_type,
                   R"(,"count":)", geometry.points.size(), R"(,"type":"VEC3","min":)",
                   triple(geometry.lower), R"(,"max":)", triple(geometry.upper),
                   R"(},{"bufferView":)", 2 * count_ + 1, R"(,"componentType":)", index_type,
                   R"(,"count":)", geometry.indices.size(), R"(,"type":"SCALAR"})");
        views_ += concat(comma, R"({"buffer":0,"byteOffset":)", bytes_, R"(,"byteLength":)", points,
                         R"(,"target":34962},{"buffer":0,"byteOffset":)", bytes_ + points,
                         R"(,"byteLength":)", indices, R"(,"target":34963})");
        bytes_ += points + indices;
        ++count_;
    }

    [[nodiscard]] std::uint64_t bytes() const noexcept { return bytes_; }

    /// Padded with spaces to a multiple of 4.
    [[nodiscard]] std::string json() const
    {
        std::string text = concat(
            R"({"asset":{"version":"2.0","generator":"proxima"},"scene":0,"scenes":[{"nodes":[)",
            scene_, R"(]}],"nodes":[)", nodes_, R"(],"meshes":[)", meshes_, R"(],"materials":[)",
            materials_, R"(],"accessors":[)", accessors_, R"(],"bufferViews":[)", views_,
            R"(],"buffers":[{"byteLength":)", bytes_, "}]}");
        text.resize((text.size() + 3) / 4 * 4, ' ');
        return text;
    }

private:
    int count_ = 0;
    std::uint64_t bytes_ = 0;
    std::string nodes_;
    std::string scene_;
    std::string meshes_;
    std::string materials_;
    std::string accessors_;
    std::string views_;
};

} // namespace

Status export_glb(const Octree& octree, const TriangleMesh& mesh, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    const Vec3 origin = octree.box(octree.root()).center();
    auto surface = mesh_geometry(mesh, origin, options.progress);
    if (!surface) return tl::unexpected(surface.error());
    auto boxes = box_geometry(octree, origin, options.progress);
    if (!boxes) return tl::unexpected(boxes.error());
    const std::array<Geometry, 2> parts = {std::move(*surface), std::move(*boxes)};
    constexpr int triangles_mode = 4;
    constexpr int lines_mode = 1;
    Document document;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (parts[i].indices.empty()) continue;
        if (!parts[i].finite) {
            return fail(ErrorCode::limit_exceeded,
                        "coordinates do not fit glTF's floats: export as .vtu, .htg or .ply",
                        path.string());
        }
        document.add(parts[i], i == 0 ? "mesh" : "boundary leaves",
                     i == 0 ? triangles_mode : lines_mode,
                     i == 0 ? "[0.8,0.8,0.78,1]" : "[0.6,0.1,0.1,1]", origin);
    }
    const std::string json = document.json();
    const std::uint64_t total = 12 + 8 + json.size() + 8 + document.bytes();
    if (total > std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat("the .glb would have ", total,
                           " bytes, at most 2^32 - 1 are possible: "
                           "lower the depth or export as .htg"),
                    path.string());
    }
    auto file = OutputFile::create(path, {options.progress, total});
    if (!file) return tl::unexpected<Error>(file.error());
    const std::array<std::uint32_t, 5> head = {glb_magic, 2, static_cast<std::uint32_t>(total),
                                               static_cast<std::uint32_t>(json.size()), json_chunk};
    const std::array<std::uint32_t, 2> middle = {static_cast<std::uint32_t>(document.bytes()),
                                                 binary_chunk};
    if (auto status = file->write(std::as_bytes(std::span(head))); !status) return status;
    if (auto status = file->write(json); !status) return status;
    if (auto status = file->write(std::as_bytes(std::span(middle))); !status) return status;
    for (const Geometry& part : parts) {
        if (auto status = file->write(std::as_bytes(std::span(part.points))); !status) {
            return status;
        }
        if (auto status = file->write(std::as_bytes(std::span(part.indices))); !status) {
            return status;
        }
    }
    return file->commit();
}

} // namespace proxima
