#include "mesh/io/glb_file.h"

#include "base/output_file.h"
#include "base/text.h"

#include <algorithm>
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

template <class T>
std::string triple(const std::array<T, 3>& values)
{
    return concat("[", values[0], ",", values[1], ",", values[2], "]");
}

/// Writes the JSON objects of one geometry after another.
class Document {
public:
    void add(const GlbPart& part, const Vec3& origin)
    {
        const std::uint64_t points = std::span(part.points).size_bytes();
        const std::uint64_t indices = std::span(part.indices).size_bytes();
        const char* const comma = count_ == 0 ? "" : ",";
        nodes_ += concat(comma, R"({"name":")", part.name, R"(","mesh":)", count_,
                         R"(,"translation":[)", origin[0], ",", origin[1], ",", origin[2], "]}");
        scene_ += concat(comma, count_);
        meshes_ += concat(comma, R"({"name":")", part.name,
                          R"(","primitives":[{"attributes":{"POSITION":)", 2 * count_,
                          R"(},"indices":)", 2 * count_ + 1, R"(,"mode":)",
                          static_cast<int>(part.mode), R"(,"material":)", count_, "}]}");
        materials_ += concat(comma, R"({"name":")", part.name, R"(","doubleSided":true,)",
                             part.opacity < 1 ? R"("alphaMode":"BLEND",)" : "",
                             R"("pbrMetallicRoughness":{"baseColorFactor":[)", part.colour[0], ",",
                             part.colour[1], ",", part.colour[2], ",", part.opacity,
                             R"(],"metallicFactor":0,"roughnessFactor":0.8}})");
        accessors_ +=
            concat(comma, R"({"bufferView":)", 2 * count_, R"(,"componentType":)", float_type,
                   R"(,"count":)", part.points.size(), R"(,"type":"VEC3","min":)",
                   triple(part.lower), R"(,"max":)", triple(part.upper), R"(},{"bufferView":)",
                   2 * count_ + 1, R"(,"componentType":)", index_type, R"(,"count":)",
                   part.indices.size(), R"(,"type":"SCALAR"})");
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

void GlbPart::add_point(const Vec3& point, const Vec3& origin)
{
    std::array<float, 3> single{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        single[axis] = static_cast<float>(point[i] - origin[i]);
        finite = finite && std::isfinite(single[axis]);
        lower[axis] = points.empty() ? single[axis] : std::min(lower[axis], single[axis]);
        upper[axis] = points.empty() ? single[axis] : std::max(upper[axis], single[axis]);
    }
    points.push_back(single);
}

Status write_glb(std::span<const GlbPart> parts, const Vec3& origin,
                 const std::filesystem::path& path, Progress* progress)
{
    Document document;
    for (const GlbPart& part : parts) {
        if (part.indices.empty()) continue;
        if (!part.finite) {
            return fail(ErrorCode::limit_exceeded,
                        "coordinates do not fit glTF's floats: write another format",
                        path.string());
        }
        document.add(part, origin);
    }
    const std::string json = document.json();
    const std::uint64_t total = 12 + 8 + json.size() + 8 + document.bytes();
    if (total > std::numeric_limits<std::uint32_t>::max()) {
        return fail(ErrorCode::limit_exceeded,
                    concat("the .glb would have ", total,
                           " bytes, at most 2^32 - 1 are possible: write less, or another format"),
                    path.string());
    }
    auto file = OutputFile::create(path, {progress, total});
    if (!file) return tl::unexpected<Error>(file.error());
    const std::array<std::uint32_t, 5> head = {glb_magic, 2, static_cast<std::uint32_t>(total),
                                               static_cast<std::uint32_t>(json.size()), json_chunk};
    const std::array<std::uint32_t, 2> middle = {static_cast<std::uint32_t>(document.bytes()),
                                                 binary_chunk};
    if (auto status = file->write(std::as_bytes(std::span(head))); !status) return status;
    if (auto status = file->write(json); !status) return status;
    if (auto status = file->write(std::as_bytes(std::span(middle))); !status) return status;
    for (const GlbPart& part : parts) {
        if (part.indices.empty()) continue;
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
