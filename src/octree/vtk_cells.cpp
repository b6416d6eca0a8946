#include "octree/vtk_cells.h"

#include "base/progress.h"
#include "base/text.h"
#include "octree/vtk_xml.h"

#include <algorithm>
#include <array>

namespace proxima {

namespace {

void append_cell_data(VtkXml& xml, std::span<const CellData> data, const std::string& attributes)
{
    xml.text(concat("<CellData Scalars=\"", data.front().name, "\">\n"));
    for (const CellData& array : data) {
        xml.array(array.type, concat(R"(Name=")", array.name, R"(")", attributes), array.bytes);
    }
    xml.text("</CellData>\n");
}

} // namespace

Status write_leaf_voxels(const OctreeFrame& frame, int lattice_depth,
                         const std::vector<LeafBox>& leaves, std::span<const CellData> data,
                         const std::filesystem::path& path, Progress* progress)
{
    constexpr std::uint8_t vtk_voxel = 11; // corners in the order of octants
    const auto corners = LeafCorners::find(leaves, progress);
    if (!corners) return tl::unexpected(corners.error());
    StageSteps steps(progress, "arranging cells", corners->size() + 8 * leaves.size());
    std::vector<double> points;
    points.reserve(3 * corners->size());
    for (std::size_t i = 0; i < corners->size(); ++i) {
        const Vec3 point = corners->position(frame, lattice_depth, i);
        points.insert(points.end(), point.begin(), point.end());
        if (!steps.done(1)) return cancelled("the export");
    }
    std::vector<std::int64_t> connectivity;
    std::vector<std::int64_t> offsets;
    connectivity.reserve(8 * leaves.size());
    offsets.reserve(leaves.size());
    for (const LeafBox& leaf : leaves) {
        for (int corner = 0; corner < 8; ++corner) {
            connectivity.push_back(static_cast<std::int64_t>(corners->number(leaf, corner)));
        }
        offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
        if (!steps.done(8)) return cancelled("the export");
    }
    const std::vector<std::uint8_t> types(leaves.size(), vtk_voxel);

    VtkXml xml("UnstructuredGrid", "1.0");
    xml.text(concat("<UnstructuredGrid>\n<Piece NumberOfPoints=\"", corners->size(),
                    R"(" NumberOfCells=")", leaves.size(), "\">\n<Points>\n"));
    xml.array("Float64", R"(Name="Points" NumberOfComponents="3")",
              std::as_bytes(std::span(points)));
    xml.text("</Points>\n<Cells>\n");
    xml.array("Int64", R"(Name="connectivity")", std::as_bytes(std::span(connectivity)));
    xml.array("Int64", R"(Name="offsets")", std::as_bytes(std::span(offsets)));
    xml.array("UInt8", R"(Name="types")", std::as_bytes(std::span(types)));
    xml.text("</Cells>\n");
    append_cell_data(xml, data, "");
    xml.text("</Piece>\n</UnstructuredGrid>\n");
    return xml.write(path, progress);
}

void SplitCells::add_level(const std::vector<bool>& split)
{
    cells_at_depth_.push_back(static_cast<std::int64_t>(split.size()));
    if (std::find(split.begin(), split.end(), true) == split.end()) return;
    for (const bool bit : split) {
        if (bit_count_ % 8 == 0) bits_.push_back(0);
        if (bit) bits_.back() = static_cast<std::uint8_t>(bits_.back() | 0x80U >> bit_count_ % 8);
        ++bit_count_;
    }
}

Status write_hyper_tree(const Box& root, const SplitCells& cells, std::span<const CellData> data,
                        const std::filesystem::path& path, Progress* progress)
{
    std::array<std::array<double, 2>, 3> planes{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        planes[axis] = {root.lower[i], root.upper[i]};
    }
    std::int64_t all = 0;
    for (const std::int64_t count : cells.cells_at_depth()) all += count;
    const std::int64_t tree_id = 0;
    const auto levels = static_cast<std::uint32_t>(cells.cells_at_depth().size());

    VtkXml xml("HyperTreeGrid", "2.0");
    xml.text(R"(<HyperTreeGrid BranchFactor="2" TransposedRootIndexing="0" )"
             "Dimensions=\"2 2 2\">\n<Grid>\n");
    constexpr std::array<const char*, 3> names = {"XCoordinates", "YCoordinates", "ZCoordinates"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        xml.array("Float64", concat(R"(Name=")", names[axis], R"(" NumberOfTuples="2")"),
                  std::as_bytes(std::span(planes[axis])));
    }
    xml.text("</Grid>\n<Trees>\n");
    xml.array("Bit", concat(R"(Name="Descriptors" NumberOfTuples=")", cells.bit_count(), R"(")"),
              std::as_bytes(std::span(cells.bits())));
    xml.array("Int64",
              concat(R"(Name="NumberOfVerticesPerDepth" NumberOfTuples=")", levels, R"(")"),
              std::as_bytes(std::span(cells.cells_at_depth())));
    xml.array("Int64", R"(Name="TreeIds" NumberOfTuples="1")",
              std::as_bytes(std::span(&tree_id, 1)));
    xml.array("UInt32", R"(Name="DepthPerTree" NumberOfTuples="1")",
              std::as_bytes(std::span(&levels, 1)));
    xml.text("</Trees>\n");
    append_cell_data(xml, data, concat(R"( NumberOfTuples=")", all, R"(")"));
    xml.text("</HyperTreeGrid>\n");
    return xml.write(path, progress);
}

} // namespace proxima
