// The parts of an octree's file, for programs that write and read it in pieces (docs/file_format.md).
#pragma once

#include "base/binary_file.h"
#include "proxima/octree_io.h"

#include <array>
#include <cstdint>
#include <filesystem>

namespace proxima {

inline constexpr FileFormat octree_format{
    {'P', 'r', 'o', 'x', 'i', 'm', 'a', 'O'}, 1, "octree file"};

enum OctreeSection : std::uint32_t {
    header_section = 1,
    nodes_section = 2,
    references_section = 3
};

/// Everything but the arrays. Doubles by their bits, so that the struct has no other values.
struct OctreeFileHeader {
    std::array<std::uint64_t, 3> lower{};
    std::array<std::uint64_t, 3> edge{};
    std::uint64_t triangle_count = 0;
    std::uint64_t leaked_leaves = 0;
    std::uint32_t components = 0;
    std::uint32_t leaked_components = 0;
    std::uint32_t max_depth = 0;
    std::uint32_t threshold = 0;
    std::uint8_t method = 0;
    std::uint8_t subdivision = 0;
    std::uint8_t exact = 0;
    std::uint8_t classified = 0;
    std::uint32_t reserved = 0;
};
static_assert(sizeof(OctreeFileHeader) == 88);

[[nodiscard]] OctreeFileHeader octree_file_header(const OctreeFrame& frame,
                                                  const OctreeParameters& parameters,
                                                  std::uint64_t triangle_count);

/// As load_octree, but without a look at the nodes, which may say anything.
[[nodiscard]] Result<Octree> load_unchecked_octree(const std::filesystem::path& path,
                                                   const LoadOptions& options);

} // namespace proxima
