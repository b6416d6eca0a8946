#include "proxima/base/text.h"
#include "proxima/octree/export.h"
#include "proxima/octree/leaf_boxes.h"
#include "proxima/octree/vtk_xml.h"

namespace proxima {

Status export_vtu(const Octree& octree, const std::filesystem::path& path,
                  const ExportOptions& options)
{
    constexpr std::uint8_t vtk_voxel = 11; // corners in the order of octants
    const auto found = leaf_boxes(octree, LeafChoice::all, options.progress);
    if (!found) return tl::unexpected(found.error());
    const std::vector<LeafBox>& leaves = *found;
    const auto corners = LeafCorners::find(leaves, options.progress);
    if (!corners) return tl::unexpected(corners.error());
    StageSteps steps(options.progress, "arranging cells", corners->size() + 8 * leaves.size());
    std::vector<double> points;
    points.reserve(3 * corners->size());
    for (std::size_t i = 0; i < corners->size(); ++i) {
        const Vec3 point = corners->position(octree, i);
        points.insert(points.end(), point.begin(), point.end());
        if (!steps.done(1)) return export_cancelled();
    }
    std::vector<std::int64_t> connectivity;
    std::vector<std::int64_t> offsets;
    std::vector<std::uint8_t> classes;
    std::vector<std::uint8_t> depths;
    std::vector<std::uint32_t> triangles;
    connectivity.reserve(8 * leaves.size());
    for (const LeafBox& leaf : leaves) {
        for (int corner = 0; corner < 8; ++corner) {
            connectivity.push_back(static_cast<std::int64_t>(corners->number(leaf, corner)));
        }
        offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
        classes.push_back(static_cast<std::uint8_t>(leaf.type));
        depths.push_back(leaf.depth);
        triangles.push_back(leaf.triangles);
        if (!steps.done(8)) return export_cancelled();
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
    xml.text("</Cells>\n<CellData Scalars=\"class\">\n");
    xml.array("UInt8", R"(Name="class")", std::as_bytes(std::span(classes)));
    xml.array("UInt8", R"(Name="depth")", std::as_bytes(std::span(depths)));
    xml.array("UInt32", R"(Name="triangles")", std::as_bytes(std::span(triangles)));
    xml.text("</CellData>\n</Piece>\n</UnstructuredGrid>\n");
    return xml.write(path, options.progress);
}

} // namespace proxima
