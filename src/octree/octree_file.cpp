#include "octree/octree_file.h"

#include "base/text.h"
#include "octree/check_structure.h"

#include <bit>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

/// Values that are not values of the enums and bools in memory must be refused before they are
/// converted.
bool representable(const OctreeFileHeader& header)
{
    return header.max_depth <= static_cast<std::uint32_t>(max_octree_depth) &&
           header.method <= static_cast<std::uint8_t>(OverlapMethod::pairwise) &&
           header.subdivision <= static_cast<std::uint8_t>(Subdivision::uniform) &&
           header.exact <= 1 && header.classified <= 1 && header.reserved == 0;
}

Octree make_octree(const OctreeFileHeader& header, std::span<const OctreeNode> nodes,
                   std::span<const TriangleId> references, std::shared_ptr<const void> storage)
{
    OctreeFrame frame;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        frame.lower[i] = std::bit_cast<double>(header.lower[axis]);
        frame.edge[i] = std::bit_cast<double>(header.edge[axis]);
    }
    OctreeParameters parameters;
    parameters.max_depth = static_cast<int>(header.max_depth);
    parameters.threshold = header.threshold;
    parameters.method = static_cast<OverlapMethod>(header.method);
    parameters.subdivision = static_cast<Subdivision>(header.subdivision);
    parameters.exact = header.exact != 0;
    parameters.classified = header.classified != 0;
    parameters.classification = {header.components, header.leaked_components, header.leaked_leaves};
    return Octree::adopt(frame, parameters, header.triangle_count, nodes, references,
                         std::move(storage));
}

Result<Octree> unchecked_octree_of(const BinaryFile& file, const std::string& name)
{
    const auto headers = file.section<OctreeFileHeader>(header_section);
    if (!headers) return tl::unexpected<Error>(headers.error());
    const auto nodes = file.section<OctreeNode>(nodes_section);
    if (!nodes) return tl::unexpected<Error>(nodes.error());
    const auto references = file.section<TriangleId>(references_section);
    if (!references) return tl::unexpected<Error>(references.error());
    if (headers->size() != 1 || !representable(headers->front())) {
        return fail(ErrorCode::malformed_file, "the octree's parameters are damaged", name);
    }
    return make_octree(headers->front(), *nodes, *references, file.storage());
}

Result<Octree> octree_of(const BinaryFile& file, const std::string& name, Progress* progress)
{
    auto octree = unchecked_octree_of(file, name);
    if (!octree) return octree;
    if (const Status status = check_structure(*octree, progress); !status) {
        // A broken invariant of a built octree is a bug; in a file it is damage.
        const bool stopped = status.error().code == ErrorCode::cancelled;
        return fail(stopped ? ErrorCode::cancelled : ErrorCode::malformed_file,
                    describe(status.error()), name);
    }
    return octree;
}

Result<BinaryFile> open_file(const std::filesystem::path& path, const LoadOptions& options)
{
    return BinaryFile::open(path, octree_format,
                            {.verify = options.verify,
                             .access = options.access,
                             .budget = options.execution.budget,
                             .progress = options.execution.progress});
}

} // namespace

OctreeFileHeader octree_file_header(const OctreeFrame& frame, const OctreeParameters& parameters,
                                    std::uint64_t triangle_count)
{
    OctreeFileHeader header;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        header.lower[axis] = std::bit_cast<std::uint64_t>(frame.lower[i]);
        header.edge[axis] = std::bit_cast<std::uint64_t>(frame.edge[i]);
    }
    header.triangle_count = triangle_count;
    header.leaked_leaves = parameters.classification.leaked_leaves;
    header.components = parameters.classification.components;
    header.leaked_components = parameters.classification.leaked_components;
    header.max_depth = static_cast<std::uint32_t>(parameters.max_depth);
    header.threshold = parameters.threshold;
    header.method = static_cast<std::uint8_t>(parameters.method);
    header.subdivision = static_cast<std::uint8_t>(parameters.subdivision);
    header.exact = parameters.exact ? 1 : 0;
    header.classified = parameters.classified ? 1 : 0;
    return header;
}

Result<Octree> load_unchecked_octree(const std::filesystem::path& path, const LoadOptions& options)
{
    const auto file = open_file(path, options);
    if (!file) return tl::unexpected<Error>(file.error());
    return unchecked_octree_of(*file, path.string());
}

Status save_octree(const Octree& octree, const std::filesystem::path& path,
                   const SaveOptions& options)
{
    if (octree.nodes().empty()) {
        return fail(ErrorCode::invalid_argument,
                    "the octree is empty: build it from a mesh to save it", path.string());
    }
    const OctreeFileHeader header =
        octree_file_header(octree.frame(), octree.parameters(), octree.triangle_count());
    const std::array<BinarySection, 3> sections = {
        binary_section(header_section, std::span(&header, 1)),
        binary_section(nodes_section, octree.nodes()),
        binary_section(references_section, octree.references())};
    return write_binary_file(path, octree_format, sections, options.execution.progress);
}

Result<Octree> load_octree(const std::filesystem::path& path, const LoadOptions& options)
{
    const auto file = open_file(path, options);
    if (!file) return tl::unexpected<Error>(file.error());
    return octree_of(*file, path.string(), options.execution.progress);
}

Result<Octree> load_octree(std::span<const std::byte> bytes, std::shared_ptr<const void> storage,
                           const std::string& name, const LoadOptions& options)
{
    const auto file = BinaryFile::read(bytes, std::move(storage), name, octree_format,
                                       options.verify, options.execution.progress);
    if (!file) return tl::unexpected<Error>(file.error());
    return octree_of(*file, name, options.execution.progress);
}

} // namespace proxima
