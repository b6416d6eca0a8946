#include "mesh/io/three_ds_faces.h"

#include "base/text.h"

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace proxima::detail {

namespace {

// A chunk: kind (2 bytes), length with these 6 bytes (4), content, which may be chunks.
constexpr std::size_t chunk_header_bytes = 6;
constexpr unsigned main_chunk = 0x4D4D;
constexpr unsigned editor_chunk = 0x3D3D;
constexpr unsigned object_chunk = 0x4000; // begins with its name, which ends with a zero
constexpr unsigned mesh_chunk = 0x4100;
constexpr unsigned vertices_chunk = 0x4110; // their number (2), three floats each
constexpr unsigned faces_chunk = 0x4120;    // their number (2), three vertices and flags (2 each)
constexpr std::size_t face_bytes = 8;

unsigned number_at(std::string_view text, std::size_t position, std::size_t bytes)
{
    unsigned value = 0;
    for (std::size_t i = bytes; i > 0; --i)
        value = value << 8U | static_cast<unsigned char>(text[position + i - 1]);
    return value;
}

/// Calls `take(kind, content)` for each chunk, until it returns false or a chunk is cut off.
template <class Take>
bool for_each_chunk(std::string_view text, Take take)
{
    while (text.size() >= chunk_header_bytes) {
        const std::size_t length = number_at(text, 2, 4);
        if (length < chunk_header_bytes || length > text.size()) return true;
        if (!take(number_at(text, 0, 2),
                  text.substr(chunk_header_bytes, length - chunk_header_bytes)))
            return false;
        text.remove_prefix(length);
    }
    return true;
}

class FaceCheck {
public:
    explicit FaceCheck(const MeshSource& source) : source_(source) {}

    Status run()
    {
        for_each_chunk(source_.text, [&](unsigned kind, std::string_view content) {
            return kind != main_chunk || check(content);
        });
        return status_;
    }

private:
    /// Main and editor chunks, down to the objects.
    bool check(std::string_view content)
    {
        return for_each_chunk(content, [&](unsigned kind, std::string_view inner) {
            if (kind == editor_chunk) return check(inner);
            if (kind != object_chunk) return true;
            const std::size_t name_end = inner.find('\0');
            if (name_end == std::string_view::npos) return true;
            name_ = inner.substr(0, name_end);
            return for_each_chunk(inner.substr(name_end + 1),
                                  [&](unsigned part, std::string_view mesh) {
                                      return part != mesh_chunk || check_mesh(mesh);
                                  });
        });
    }

    bool check_mesh(std::string_view mesh)
    {
        unsigned vertices = 0;
        std::string_view faces;
        for_each_chunk(mesh, [&](unsigned kind, std::string_view content) {
            if (kind == vertices_chunk && content.size() >= 2) vertices = number_at(content, 0, 2);
            if (kind == faces_chunk && content.size() >= 2) faces = content;
            return true;
        });
        if (faces.empty()) return true;
        const std::size_t count =
            std::min<std::size_t>(number_at(faces, 0, 2), (faces.size() - 2) / face_bytes);
        for (std::size_t face = 0; face < count; ++face) {
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const unsigned vertex = number_at(faces, 2 + face * face_bytes + 2 * corner, 2);
                if (vertex < vertices) continue;
                status_ = fail(ErrorCode::malformed_file,
                               concat("face ", face, " of object ", name_, " uses vertex ", vertex,
                                      " of ", vertices),
                               source_.name);
                return false;
            }
        }
        return true;
    }

    const MeshSource& source_;
    std::string_view name_;
    Status status_;
};

} // namespace

Status check_3ds_faces(const MeshSource& source)
{
    return FaceCheck(source).run();
}

} // namespace proxima::detail
