#include "distributed/export_part.h"

#include "base/output_file.h"
#include "octree/vtk_cells.h"

#include <string>
#include <system_error>

namespace proxima {

namespace {

namespace fs = std::filesystem;

fs::path piece_path(const fs::path& path, std::size_t rank)
{
    return path.parent_path() / concat(path.stem().string(), "_", rank, ".vtu");
}

/// For an attribute's value.
std::string escaped(const std::string& text)
{
    std::string result;
    for (const char letter : text) {
        switch (letter) {
        case '&':
            result += "&amp;";
            break;
        case '<':
            result += "&lt;";
            break;
        case '"':
            result += "&quot;";
            break;
        default:
            result += letter;
        }
    }
    return result;
}

std::string list_of_pieces(const fs::path& path, const std::vector<std::uint64_t>& leaves)
{
    std::string text =
        R"(<?xml version="1.0"?>
<VTKFile type="PUnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<PUnstructuredGrid GhostLevel="0">
<PPoints>
<PDataArray type="Float64" Name="Points" NumberOfComponents="3"/>
</PPoints>
<PCellData Scalars="class">
<PDataArray type="UInt8" Name="class"/>
<PDataArray type="UInt8" Name="depth"/>
<PDataArray type="UInt32" Name="triangles"/>
</PCellData>
)";
    for (std::size_t rank = 0; rank < leaves.size(); ++rank) {
        if (leaves[rank] == 0) continue;
        text += concat("<Piece Source=\"", escaped(piece_path(path, rank).filename().string()),
                       "\"/>\n");
    }
    return text + "</PUnstructuredGrid>\n</VTKFile>\n";
}

/// Writes this rank's piece, if it has leaves, and on rank 0 the list of all. Collective.
Status write_pieces(const OctreePart& part, const fs::path& path, const fs::path& own,
                    bool& has_piece, World& world)
{
    Progress* const progress = &world.progress();
    const Octree& octree = part.octree;
    std::uint64_t count = 0;
    Status status = world.agree_on([&]() -> Status {
        const auto leaves = leaf_boxes_below(octree, part.cells, LeafChoice::all, progress);
        if (!leaves) return tl::unexpected(leaves.error());
        count = leaves->size();
        if (count == 0) return {};
        Status written = write_classified_leaves(octree.frame(), octree.parameters().max_depth,
                                                 *leaves, own, progress);
        has_piece = written.has_value();
        return written;
    });
    if (!status) return status;
    const std::vector<std::uint64_t> counts = world.gather(count);
    return world.agree_on_done([&]() -> Status {
        if (world.rank() != 0) return {};
        auto file = OutputFile::create(path);
        if (!file) return tl::unexpected(file.error());
        if (auto written = file->write(list_of_pieces(path, counts)); !written) return written;
        return file->commit();
    });
}

} // namespace

Status export_part(const OctreePart& part, const fs::path& path, World& world)
{
    Status status = world.agree_on([&]() -> Status {
        if (world.rank() != 0) return {};
        const auto tried = OutputFile::create(path); // thrown away uncommitted
        if (!tried) return tl::unexpected(tried.error());
        std::error_code error;
        fs::remove(path, error);
        if (!error) return {};
        return fail(ErrorCode::file_not_writable, concat("cannot replace it: ", error.message()),
                    path.string());
    });
    if (!status) return status;
    const fs::path own = piece_path(path, static_cast<std::size_t>(world.rank()));
    bool has_piece = false;
    status = write_pieces(part, path, own, has_piece, world);
    std::error_code error;
    if (!status && has_piece) fs::remove(own, error);
    return status;
}

} // namespace proxima
