#include "mesh/io/mesh_writers.h"

#include "base/output_file.h"
#include "base/progress.h"
#include "base/text.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

namespace proxima::detail {

namespace {

// Collects a file's bytes and writes them in blocks. Keeps the first failure.
class MeshOutput {
public:
    MeshOutput(const TriangleMesh& mesh, const std::filesystem::path& path,
               const WriteOptions& options)
        : name_(path.string()), progress_(options.execution.progress)
    {
        begin_stage(progress_, "writing mesh", mesh.triangle_count());
        auto file = OutputFile::create(path);
        if (file) {
            file_ = std::move(*file);
        } else {
            status_ = tl::unexpected(file.error());
        }
        block_.reserve(block_size + 1024);
    }

    MeshOutput& text(std::string_view text)
    {
        block_ += text;
        return *this;
    }

    /// The shortest text that reads back to the same bits.
    template <class Number>
    MeshOutput& number(Number value)
    {
        char digits[32];
        const auto end = std::to_chars(std::begin(digits), std::end(digits), value).ptr;
        block_.append(digits, end);
        return *this;
    }

    /// Writes three numbers separated by blanks.
    template <class Triple>
    MeshOutput& numbers(const Triple& values)
    {
        return number(values[0]).text(" ").number(values[1]).text(" ").number(values[2]);
    }

    /// Little-endian bytes.
    template <class Unsigned>
    MeshOutput& bytes(Unsigned value)
    {
        for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
            block_ += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
        }
        return *this;
    }

    /// Called between records. Returns false where writing should stop.
    [[nodiscard]] bool may_continue()
    {
        if (block_.size() >= block_size) flush();
        return status_.has_value();
    }

    /// Counts a finished triangle.
    void advance()
    {
        if (++triangles_done_ % report_interval != 0 || progress_ == nullptr) return;
        progress_->advance(report_interval);
    }

    void refuse(ErrorCode code, std::string message)
    {
        if (status_) status_ = fail(code, std::move(message), name_);
    }

    [[nodiscard]] Status commit()
    {
        flush();
        if (!status_) return status_;
        return file_->commit();
    }

private:
    static constexpr std::size_t block_size = std::size_t{1} << 16U;
    static constexpr std::uint64_t report_interval = 4096;

    void flush()
    {
        if (status_ && is_cancelled(progress_)) status_ = cancelled("writing", name_);
        if (status_) status_ = file_->write(std::string_view(block_));
        block_.clear();
    }

    std::string name_;
    Progress* progress_;
    std::optional<OutputFile> file_;
    Status status_;
    std::string block_;
    std::uint64_t triangles_done_ = 0;
};

Vec3 unit_normal(const Triangle& triangle)
{
    // Scaled first, so that lengths near the limits of double have a normal too.
    const Vec3 a = triangle[1] - triangle[0];
    const Vec3 b = triangle[2] - triangle[0];
    const double size = std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
    const Vec3 normal = (a / size).cross(b / size);
    const double length = length_of(normal);
    if (!std::isfinite(length) || length == 0) return Vec3::Zero();
    return normal / length;
}

Status write_stl_text(const TriangleMesh& mesh, const std::filesystem::path& path,
                      const WriteOptions& options)
{
    MeshOutput file(mesh, path, options);
    file.text("solid proxima\n");
    for (std::uint32_t i = 0; i < mesh.triangle_count() && file.may_continue(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        file.text("facet normal ").numbers(unit_normal(triangle)).text("\nouter loop\n");
        for (const Vec3& vertex : triangle.vertices) {
            file.text("vertex ").numbers(vertex).text("\n");
        }
        file.text("endloop\nendfacet\n");
        file.advance();
    }
    file.text("endsolid proxima\n");
    return file.commit();
}

Status write_stl_binary(const TriangleMesh& mesh, const std::filesystem::path& path,
                        const WriteOptions& options)
{
    MeshOutput file(mesh, path, options);
    // A header that starts with "solid" would be read as text.
    std::string header = "binary STL written by proxima";
    header.resize(80, ' ');
    file.text(header).bytes(static_cast<std::uint32_t>(mesh.triangle_count()));
    const auto write = [&](const Vec3& values) {
        for (const double value : values) {
            const bool too_large =
                std::isfinite(value) && std::abs(value) > std::numeric_limits<float>::max();
            if (too_large) {
                file.refuse(ErrorCode::limit_exceeded,
                            concat("the coordinate ", value,
                                   " is beyond binary STL, whose numbers ",
                                   "are float32: write ASCII STL, PLY or OBJ"));
            }
            const float narrowed = too_large ? 0.0F : static_cast<float>(value);
            file.bytes(std::bit_cast<std::uint32_t>(narrowed));
        }
    };
    for (std::uint32_t i = 0; i < mesh.triangle_count() && file.may_continue(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        write(unit_normal(triangle));
        for (const Vec3& vertex : triangle.vertices) write(vertex);
        file.bytes(std::uint16_t{0});
        file.advance();
    }
    return file.commit();
}

} // namespace

Status write_obj(const TriangleMesh& mesh, const std::filesystem::path& path,
                 const WriteOptions& options)
{
    MeshOutput file(mesh, path, options);
    file.text("# written by proxima\n");
    for (const Vec3& position : mesh.positions()) {
        if (!file.may_continue()) break;
        file.text("v ").numbers(position).text("\n");
    }
    for (const TriangleCorners& corners : mesh.triangles()) {
        if (!file.may_continue()) break;
        const std::uint64_t a = corners[0];
        const std::uint64_t b = corners[1];
        const std::uint64_t c = corners[2];
        file.text("f ").numbers(std::array{a + 1, b + 1, c + 1}).text("\n");
        file.advance();
    }
    return file.commit();
}

Status write_off(const TriangleMesh& mesh, const std::filesystem::path& path,
                 const WriteOptions& options)
{
    MeshOutput file(mesh, path, options);
    // The third number, of edges, is read by nobody.
    file.text("OFF\n").numbers(
        std::array<std::size_t, 3>{mesh.vertex_count(), mesh.triangle_count(), 0});
    file.text("\n");
    for (const Vec3& position : mesh.positions()) {
        if (!file.may_continue()) break;
        file.numbers(position).text("\n");
    }
    for (const TriangleCorners& corners : mesh.triangles()) {
        if (!file.may_continue()) break;
        file.text("3 ").numbers(corners).text("\n");
        file.advance();
    }
    return file.commit();
}

Status write_ply(const TriangleMesh& mesh, const std::filesystem::path& path,
                 const WriteOptions& options)
{
    MeshOutput file(mesh, path, options);
    const bool is_text = options.ply == PlyEncoding::ascii;
    // "int" is what most readers expect; it holds all but the largest meshes.
    const bool is_large = mesh.vertex_count() > std::numeric_limits<std::int32_t>::max();
    file.text("ply\nformat ").text(is_text ? "ascii" : "binary_little_endian").text(" 1.0\n");
    file.text("comment written by proxima\nelement vertex ").number(mesh.vertex_count());
    file.text("\nproperty double x\nproperty double y\nproperty double z\nelement face ");
    file.number(mesh.triangle_count()).text("\nproperty list uchar ");
    file.text(is_large ? "uint" : "int").text(" vertex_indices\nend_header\n");
    for (const Vec3& position : mesh.positions()) {
        if (!file.may_continue()) break;
        if (is_text) {
            file.numbers(position).text("\n");
        } else {
            for (const double value : position) file.bytes(std::bit_cast<std::uint64_t>(value));
        }
    }
    for (const TriangleCorners& corners : mesh.triangles()) {
        if (!file.may_continue()) break;
        if (is_text) {
            file.text("3 ").numbers(corners).text("\n");
        } else {
            file.bytes(std::uint8_t{3});
            for (const std::uint32_t corner : corners) file.bytes(corner);
        }
        file.advance();
    }
    return file.commit();
}

Status write_stl(const TriangleMesh& mesh, const std::filesystem::path& path,
                 const WriteOptions& options)
{
    return options.stl == StlEncoding::ascii ? write_stl_text(mesh, path, options)
                                             : write_stl_binary(mesh, path, options);
}

} // namespace proxima::detail
