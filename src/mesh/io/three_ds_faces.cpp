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

/// Calls `take(kind, content)` for each chunk, until one is cut off by the end of the text. assimp reads a
/// chunk that is longer than the one around it, so here texts end with the file.
template <class Take>
void for_each_chunk(std::string_view text, std::size_t bytes, Take take)
{
    std::size_t position = 0;
    while (position < bytes && text.size() - position >= chunk_header_bytes) {
        const std::size_t length = number_at(text, position + 2, 4);
        if (length < chunk_header_bytes || length > text.size() - position) return;
        take(number_at(text, position, 2), text.substr(position + chunk_header_bytes),
             length - chunk_header_bytes);
        position += length;
    }
}

class FaceCheck {
public:
    explicit FaceCheck(const MeshSource& source) : source_(source) {}

    /// Three levels, as assimp has them: what lies deeper is not looked at.
    Status run()
    {
        using Text = std::string_view;
        const Text file = source_.text;
        for_each_chunk(file, file.size(), [&](unsigned kind, Text main, std::size_t bytes) {
            if (kind != main_chunk) return;
            for_each_chunk(main, bytes, [&](unsigned part, Text editor, std::size_t size) {
                if (part != editor_chunk) return;
                for_each_chunk(editor, size, [&](unsigned item, Text object, std::size_t length) {
                    if (item == object_chunk) check_object(object, length);
                });
            });
        });
        return status_;
    }

private:
    void check_object(std::string_view text, std::size_t bytes)
    {
        const std::size_t name_end = text.find('\0');
        if (name_end >= bytes) return;
        name_ = text.substr(0, name_end);
        for_each_chunk(text.substr(name_end + 1), bytes - name_end - 1,
                       [&](unsigned kind, std::string_view mesh, std::size_t length) {
                           if (kind == mesh_chunk) check_mesh(mesh, length);
                       });
    }

    void check_mesh(std::string_view mesh, std::size_t bytes)
    {
        // assimp joins several lists.
        std::size_t vertices = 0;
        for_each_chunk(mesh, bytes, [&](unsigned kind, std::string_view list, std::size_t length) {
            if (kind == vertices_chunk && length >= 2) vertices += number_at(list, 0, 2);
        });
        for_each_chunk(mesh, bytes, [&](unsigned kind, std::string_view list, std::size_t length) {
            if (kind == faces_chunk && length >= 2) check_faces(list, vertices);
        });
    }

    void check_faces(std::string_view faces, std::size_t vertices)
    {
        const std::size_t count =
            std::min<std::size_t>(number_at(faces, 0, 2), (faces.size() - 2) / face_bytes);
        for (std::size_t face = 0; face < count && status_; ++face) {
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const unsigned vertex = number_at(faces, 2 + face * face_bytes + 2 * corner, 2);
                if (vertex < vertices) continue;
                status_ = fail(ErrorCode::malformed_file,
                               concat("face ", face, " of object ", name_, " uses vertex ", vertex,
                                      " of ", vertices),
                               source_.name);
            }
        }
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
