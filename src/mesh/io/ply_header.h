// The header of a PLY file: its encoding and the layout of its elements.
//
//     ply
//     format ascii 1.0
//     element vertex 8           elements follow in this order, each with its properties in theirs
//     property float x
//     element face 12
//     property list uchar int vertex_indices
//     end_header
//
// [turk-1994]
#pragma once

#include "mesh/io/mesh_source.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace proxima::detail {

enum class PlyBody : std::uint8_t { ascii, little_endian, big_endian };

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Bytes of one value in a binary body.
[[nodiscard]] constexpr std::size_t size_of(PlyType type) noexcept
{
    constexpr std::uint8_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

struct PlyProperty {
    std::string_view name;
    PlyType type{};                     ///< of the value, or of the list's items
    std::optional<PlyType> length_type; ///< only of lists
};

struct PlyElement {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};

/// Names point into the text of the source.
struct PlyHeader {
    PlyBody body_kind{};
    std::vector<PlyElement> elements;
    std::string_view body; ///< all that follows the header
};

/// Error malformed_file with the line of what is not a header, unsupported_format for a version or
/// encoding that is not 1.0 ascii, binary_little_endian or binary_big_endian.
[[nodiscard]] Result<PlyHeader> read_ply_header(const MeshSource& source);

} // namespace proxima::detail
