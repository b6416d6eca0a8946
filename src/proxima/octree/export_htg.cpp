// VTK's HyperTreeGrid, XML version 2.0: one tree, its cells breadth first, children x fastest. The
// descriptor has a bit for every cell above the deepest level: 1 where it is split.
#include "proxima/base/text.h"
#include "proxima/octree/export.h"
#include "proxima/octree/leaf_boxes.h"
#include "proxima/octree/vtk_xml.h"

#include <array>

namespace proxima {

namespace {

struct Descriptor {
    std::vector<std::uint8_t> bits; ///< eight cells each, the first in the highest bit
    std::uint64_t count = 0;

    void push(bool split)
    {
        if (count % 8 == 0) bits.push_back(0);
        if (split) bits.back() = static_cast<std::uint8_t>(bits.back() | 0x80U >> count % 8);
        ++count;
    }
};

} // namespace

Status export_htg(const Octree& octree, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    StageSteps steps(options.progress, "collecting cells", octree.nodes().size());
    Descriptor descriptor;
    std::vector<std::int64_t> cells_at_depth;
    std::vector<std::uint8_t> classes;
    std::vector<std::uint8_t> depths;
    std::vector<std::uint32_t> triangles;
    std::vector<Cell> level = {octree.root()};
    while (!level.empty()) {
        std::vector<Cell> below;
        std::vector<bool> split;
        for (const Cell& cell : level) {
            if (!steps.done(1)) return export_cancelled();
            split.push_back(!octree.is_leaf(cell));
            classes.push_back(static_cast<std::uint8_t>(cell.type));
            depths.push_back(static_cast<std::uint8_t>(cells_at_depth.size()));
            triangles.push_back(
                split.back() ? 0U : static_cast<std::uint32_t>(octree.triangles(cell).size()));
            if (!split.back()) continue;
            for (int octant = 0; octant < 8; ++octant) below.push_back(octree.child(cell, octant));
        }
        if (!below.empty()) {
            for (const bool bit : split) descriptor.push(bit);
        }
        cells_at_depth.push_back(static_cast<std::int64_t>(level.size()));
        level = std::move(below);
    }
    const Box root = octree.box(octree.root());
    std::array<std::array<double, 2>, 3> planes{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        planes[axis] = {root.lower[i], root.upper[i]};
    }
    const std::int64_t tree_id = 0;
    const auto levels = static_cast<std::uint32_t>(cells_at_depth.size());

    VtkXml xml("HyperTreeGrid", "2.0");
    xml.text(R"(<HyperTreeGrid BranchFactor="2" TransposedRootIndexing="0" )"
             "Dimensions=\"2 2 2\">\n<Grid>\n");
    constexpr std::array<const char*, 3> names = {"XCoordinates", "YCoordinates", "ZCoordinates"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        xml.array("Float64", concat(R"(Name=")", names[axis], R"(" NumberOfTuples="2")"),
                  std::as_bytes(std::span(planes[axis])));
    }
    xml.text("</Grid>\n<Trees>\n");
    xml.array("Bit", concat(R"(Name="Descriptors" NumberOfTuples=")", descriptor.count, R"(")"),
              std::as_bytes(std::span(descriptor.bits)));
    xml.array("Int64",
              concat(R"(Name="NumberOfVerticesPerDepth" NumberOfTuples=")", levels, R"(")"),
              std::as_bytes(std::span(cells_at_depth)));
    xml.array("Int64", R"(Name="TreeIds" NumberOfTuples="1")",
              std::as_bytes(std::span(&tree_id, 1)));
    xml.array("UInt32", R"(Name="DepthPerTree" NumberOfTuples="1")",
              std::as_bytes(std::span(&levels, 1)));
    xml.text("</Trees>\n<CellData Scalars=\"class\">\n");
    const std::string tuples = concat(R"( NumberOfTuples=")", classes.size(), R"(")");
    xml.array("UInt8", R"(Name="class")" + tuples, std::as_bytes(std::span(classes)));
    xml.array("UInt8", R"(Name="depth")" + tuples, std::as_bytes(std::span(depths)));
    xml.array("UInt32", R"(Name="triangles")" + tuples, std::as_bytes(std::span(triangles)));
    xml.text("</CellData>\n</HyperTreeGrid>\n");
    return xml.write(path, options.progress);
}

} // namespace proxima
