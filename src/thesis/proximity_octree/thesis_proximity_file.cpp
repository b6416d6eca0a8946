#include "thesis/proximity_octree/thesis_proximity_file.h"

#include "base/binary_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace proxima {

namespace {

constexpr FileFormat file_format{
    {'P', 'r', 'o', 'x', 'i', 'm', 'a', 'T'}, 1, "file of a thesis proximity octree"};

enum SectionId : std::uint32_t {
    header_section = 1,
    nodes_section = 2,
    leaves_section = 3,
    labels_section = 4
};

/// Everything but the arrays. Doubles by their bits, so that the struct has no other values.
struct FileHeader {
    std::array<std::uint64_t, 3> lower{};
    std::array<std::uint64_t, 3> edge{};
    std::uint64_t margin = 0;
    std::array<std::uint64_t, 3> features{}; ///< vertices, edges, faces of the mesh
    std::uint64_t fingerprint = 0;           ///< of the mesh
    std::uint32_t max_depth = 0;
    std::array<std::uint32_t, 3> thresholds{}; ///< by kind
};
static_assert(sizeof(FileHeader) == 104);

/// A leaf as the file has it.
struct FileLeaf {
    std::uint32_t first = 0;
    std::array<std::uint32_t, 3> closest{};
    std::array<std::uint32_t, 3> touching{};
    std::uint32_t type = 0;
};
static_assert(sizeof(FileLeaf) == 32);

FileHeader header_of(const ThesisProximityOctree::Parts& parts)
{
    FileHeader header;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        header.lower[axis] = std::bit_cast<std::uint64_t>(parts.frame.lower[i]);
        header.edge[axis] = std::bit_cast<std::uint64_t>(parts.frame.edge[i]);
    }
    header.margin = std::bit_cast<std::uint64_t>(parts.margin);
    header.features = {parts.features.vertices, parts.features.edges, parts.features.faces};
    header.fingerprint = parts.fingerprint;
    header.max_depth = static_cast<std::uint32_t>(parts.max_depth);
    header.thresholds = {parts.thresholds.vertex, parts.thresholds.edge, parts.thresholds.face};
    return header;
}

/// False where the header has a value that no octree has.
bool read_header(const FileHeader& header, ThesisProximityOctree::Parts& parts)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        parts.frame.lower[i] = std::bit_cast<double>(header.lower[axis]);
        parts.frame.edge[i] = std::bit_cast<double>(header.edge[axis]);
    }
    parts.margin = std::bit_cast<double>(header.margin);
    parts.max_depth = static_cast<int>(std::min<std::uint32_t>(header.max_depth, 255));
    parts.thresholds = {header.thresholds[0], header.thresholds[1], header.thresholds[2]};
    parts.features = {header.features[0], header.features[1], header.features[2]};
    parts.fingerprint = header.fingerprint;
    return parts.frame.lower.allFinite() && parts.frame.edge.allFinite() &&
           parts.frame.edge.minCoeff() > 0 && parts.margin >= 0 &&
           parts.margin <= max_root_margin && parts.max_depth <= max_octree_depth;
}

/// Whether a leaf's lists begin at that label, as the builder wrote them leaf after leaf, lie in the
/// labels, and name features of the mesh. Sets the label to the one after them.
bool is_sound(const ThesisLeaf& leaf, const ThesisProximityOctree::Parts& parts, std::size_t& first)
{
    const std::array<std::size_t, 3> features = {parts.features.vertices, parts.features.edges,
                                                 parts.features.faces};
    // Lists that overlap would take time with the square of the file's size.
    if (leaf.first != first) return false;
    for (std::size_t kind = 0; kind < 3; ++kind) {
        if (leaf.touching[kind] > leaf.closest[kind]) return false;
        if (first + leaf.closest[kind] > parts.labels.size()) return false;
        const auto list = std::span(parts.labels).subspan(first, leaf.closest[kind]);
        if (std::ranges::any_of(list, [&](std::uint32_t id) { return id >= features[kind]; }))
            return false;
        first += leaf.closest[kind];
    }
    return true;
}

/// Whether the nodes are a tree: the builder's breadth-first order, every leaf reached once. Finds
/// the depth reached.
bool is_tree(ThesisProximityOctree::Parts& parts)
{
    constexpr std::uint32_t leaf_bit = ThesisProximityOctree::leaf_bit;
    std::size_t level_begin = 0;
    std::size_t level_end = 1;
    std::size_t leaves = 0;
    for (int depth = 0; depth <= parts.max_depth; ++depth) {
        std::size_t next = level_end;
        for (std::size_t i = level_begin; i < level_end; ++i) {
            if (i >= parts.nodes.size()) return false;
            const std::uint32_t node = parts.nodes[i];
            if ((node & leaf_bit) != 0) {
                if ((node & ~leaf_bit) != leaves++) return false;
            } else {
                if (node != next) return false;
                next += 8;
            }
        }
        parts.depth_reached = depth;
        if (next == level_end) break;
        level_begin = level_end;
        level_end = next;
        if (depth == parts.max_depth) return false;
    }
    return level_end == parts.nodes.size() && leaves == parts.leaves.size();
}

Result<ThesisProximityOctree> octree_of(const BinaryFile& file, const std::string& name)
{
    const auto headers = file.section<FileHeader>(header_section);
    if (!headers) return tl::unexpected<Error>(headers.error());
    const auto nodes = file.section<std::uint32_t>(nodes_section);
    if (!nodes) return tl::unexpected<Error>(nodes.error());
    const auto leaves = file.section<FileLeaf>(leaves_section);
    if (!leaves) return tl::unexpected<Error>(leaves.error());
    const auto labels = file.section<std::uint32_t>(labels_section);
    if (!labels) return tl::unexpected<Error>(labels.error());
    ThesisProximityOctree::Parts parts;
    if (headers->size() != 1 || !read_header(headers->front(), parts))
        return fail(ErrorCode::malformed_file, "the octree's parameters are damaged", name);
    parts.nodes.assign(nodes->begin(), nodes->end());
    parts.labels.assign(labels->begin(), labels->end());
    parts.leaves.reserve(leaves->size());
    bool sound = true;
    std::size_t next_label = 0;
    for (const FileLeaf& read : *leaves) {
        sound = sound && read.type <= static_cast<std::uint32_t>(CellClass::boundary);
        if (!sound) break;
        const ThesisLeaf leaf{read.first, read.closest, read.touching,
                              static_cast<CellClass>(read.type)};
        sound = is_sound(leaf, parts, next_label);
        parts.leaves.push_back(leaf);
    }
    if (!sound || !is_tree(parts))
        return fail(ErrorCode::malformed_file, "the octree contradicts itself", name);
    return ThesisProximityOctree(std::move(parts));
}

} // namespace

Status save_thesis_proximity_octree(const ThesisProximityOctree& octree,
                                    const std::filesystem::path& path, Progress* progress)
{
    const ThesisProximityOctree::Parts& parts = octree.parts();
    const FileHeader header = header_of(parts);
    std::vector<FileLeaf> leaves;
    leaves.reserve(parts.leaves.size());
    for (const ThesisLeaf& leaf : parts.leaves) {
        leaves.push_back(
            {leaf.first, leaf.closest, leaf.touching, static_cast<std::uint32_t>(leaf.type)});
    }
    const std::array<BinarySection, 4> sections = {
        binary_section(header_section, std::span(&header, 1)),
        binary_section(nodes_section, std::span<const std::uint32_t>(parts.nodes)),
        binary_section(leaves_section, std::span<const FileLeaf>(leaves)),
        binary_section(labels_section, std::span<const std::uint32_t>(parts.labels))};
    return write_binary_file(path, file_format, sections, progress);
}

Result<ThesisProximityOctree> load_thesis_proximity_octree(const std::filesystem::path& path,
                                                           Progress* progress)
{
    const auto file = BinaryFile::open(path, file_format, {.progress = progress});
    if (!file) return tl::unexpected<Error>(file.error());
    return octree_of(*file, path.string());
}

Result<ThesisProximityOctree> load_thesis_proximity_octree(std::span<const std::byte> bytes,
                                                           std::shared_ptr<const void> storage,
                                                           const std::string& name,
                                                           Progress* progress)
{
    const auto file = BinaryFile::read(bytes, std::move(storage), name, file_format,
                                       Verification::full, progress);
    if (!file) return tl::unexpected<Error>(file.error());
    return octree_of(*file, name);
}

} // namespace proxima
