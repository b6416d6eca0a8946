#include "octree/grow_part.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "octree/fast_child_test.h"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <new>
#include <utility>

namespace proxima {

namespace {

/// Cells of the deepest level that lie below a cell: [first, end) in Morton order.
struct MortonRange {
    std::uint64_t first = 0;
    std::uint64_t end = 0;
};

MortonRange morton_range(CellKey key) noexcept
{
    const int level = depth(key);
    const int shift = 3 * (max_octree_depth - level);
    const std::uint64_t morton = key.bits ^ (std::uint64_t{1} << (3 * level));
    return {morton << shift, (morton + 1) << shift};
}

Status check_frame(const TriangleMesh& mesh, const OctreeFrame& frame)
{
    if (!frame.lower.allFinite() || !frame.edge.allFinite() || frame.edge.minCoeff() <= 0) {
        return fail(ErrorCode::invalid_argument,
                    "the root must have finite corners and positive edges");
    }
    if (mesh.triangle_count() == 0) return {};
    const auto box = checked_bounding_box(mesh);
    if (!box) return tl::unexpected(box.error());
    constexpr double largest = 1e100;
    if (box->lower.minCoeff() < -largest || box->upper.maxCoeff() > largest) {
        return fail(ErrorCode::invalid_mesh,
                    "coordinates beyond 1e100 would overflow exact arithmetic: scale the mesh");
    }
    const Box root = cell_box(frame, CellKey{});
    if (root.contains(box->lower) && root.contains(box->upper)) return {};
    return fail(ErrorCode::invalid_mesh, "the mesh reaches out of the root: enlarge the root");
}

Status check_list(const CellTriangles& cell, std::size_t index, std::size_t triangle_count)
{
    std::uint64_t least = 0; // what the next id may be
    for (const TriangleId id : cell.triangles) {
        if (to_index(id) >= triangle_count) {
            return fail(ErrorCode::invalid_argument,
                        concat("cell ", index, " lists triangle ", to_index(id),
                               " but the mesh has ", triangle_count, ", counted from 0"));
        }
        if (to_index(id) < least) {
            return fail(ErrorCode::invalid_argument,
                        concat("cell ", index,
                               " lists triangles that do not ascend: sort them, each once"));
        }
        least = std::uint64_t{to_index(id)} + 1;
    }
    return {};
}

Status check_cells(std::span<const CellTriangles> cells, std::size_t triangle_count, int max_depth)
{
    if (max_depth < 0 || max_depth > max_octree_depth) {
        return fail(ErrorCode::invalid_argument, concat("the maximum depth must be 0 to ",
                                                        max_octree_depth, ", not ", max_depth));
    }
    std::uint64_t end = 0; // of the cells so far
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const CellKey key = cells[i].key;
        const bool is_key = key.bits != 0 && (std::bit_width(key.bits) - 1) % 3 == 0;
        if (!is_key || depth(key) > max_depth) {
            return fail(ErrorCode::invalid_argument,
                        concat("cell ", i, " has the key ", key.bits,
                               ", which is none of depth 0 to ", max_depth));
        }
        const MortonRange range = morton_range(key);
        if (range.first < end) {
            return fail(ErrorCode::invalid_argument,
                        concat("cell ", i,
                               " overlaps an earlier one or is not in Morton order: sort them"));
        }
        end = range.end;
        Status status = check_list(cells[i], i, triangle_count);
        if (!status) return status;
    }
    return {};
}

/// Splits the root down to cells.
class PathWriter {
public:
    PathWriter(std::span<const CellTriangles> cells, CellsElsewhere elsewhere,
               OctreeOutput& output) noexcept
        : cells_(cells), elsewhere_(elsewhere), output_(output)
    {}

    /// Splits down to cells[which[i]]; the records of those with triangles, in their order.
    std::vector<std::uint32_t> write(std::span<const std::size_t> which)
    {
        std::vector<std::uint32_t> records;
        if (which.empty() || is_empty_cell(CellKey{}, which)) return records;
        output_.nodes.push_back(OctreeNode{});
        descend(CellKey{}, 0, which, records);
        return records;
    }

private:
    [[nodiscard]] bool is_empty_cell(CellKey key, std::span<const std::size_t> in_it) const
    {
        const CellTriangles& first = cells_[in_it.front()];
        return first.key == key && first.triangles.empty();
    }

    /// The cells that are left lie in the cell `key`, whose node is `record`.
    void descend(CellKey key, std::uint32_t record, std::span<const std::size_t> left,
                 std::vector<std::uint32_t>& records)
    {
        if (cells_[left.front()].key == key) {
            records.push_back(record);
            return;
        }
        struct Part {
            CellKey key;
            std::span<const std::size_t> cells;
        };
        std::array<Part, 8> parts;
        std::size_t count = 0;
        std::uint32_t recorded = 0;
        for (int octant = 0; octant < 8; ++octant) {
            const CellKey below = child(key, octant);
            const std::uint64_t end = morton_range(below).end;
            const auto behind = std::ranges::find_if(left, [&](std::size_t cell) {
                return morton_range(cells_[cell].key).first >= end;
            });
            const auto in_child = static_cast<std::size_t>(behind - left.begin());
            const auto cells = left.first(in_child);
            left = left.subspan(in_child);
            const bool is_left_out = in_child == 0 ? elsewhere_ == CellsElsewhere::unrecorded
                                                   : is_empty_cell(below, cells);
            if (is_left_out) continue;
            parts[count++] = {below, cells};
            recorded |= 1U << static_cast<unsigned>(octant);
        }
        const auto first = static_cast<std::uint32_t>(output_.nodes.size());
        output_.nodes[record] = OctreeNode::split(first, recorded);
        for (std::size_t i = 0; i < count; ++i) output_.nodes.push_back(OctreeNode::leaf(0, 0));
        for (std::size_t i = 0; i < count; ++i) {
            if (parts[i].cells.empty()) continue;
            descend(parts[i].key, first + static_cast<std::uint32_t>(i), parts[i].cells, records);
        }
    }

    std::span<const CellTriangles> cells_;
    CellsElsewhere elsewhere_;
    OctreeOutput& output_;
};

Result<GrownPart> grow_unguarded(const TriangleMesh& mesh, const OctreeFrame& frame,
                                 std::span<const CellTriangles> cells, CellsElsewhere elsewhere,
                                 const GrowCellsOptions& options)
{
    if (auto status = check_cells(cells, mesh.triangle_count(), options.max_depth); !status) {
        return tl::unexpected(status.error());
    }
    if (auto status = check_frame(mesh, frame); !status) return tl::unexpected(status.error());
    Progress* const progress = options.execution.progress;
    GrowLimits limits;
    limits.max_depth = options.max_depth;
    limits.threshold = options.threshold;
    limits.budget_bytes = budget_bytes(options.execution.budget);
    limits.progress = progress;
    limits.used_bytes = sizeof(SnappedPoint) * mesh.vertex_count();
    if (auto status = check_budget({limits.budget_bytes}, limits.used_bytes, "the octree's scratch",
                                   "raise the budget");
        !status) {
        return tl::unexpected(status.error());
    }

    begin_stage(progress, "snapping", mesh.vertex_count());
    const SnappedMesh snapped(mesh, frame, Threads{1}, progress);
    if (is_cancelled(progress)) return cancelled("growing cells");
    GrownPart grown;
    std::vector<std::size_t> occupied;
    std::vector<std::size_t> all;
    std::uint64_t references = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (!cells[i].triangles.empty()) occupied.push_back(i);
        all.push_back(i);
        references += cells[i].triangles.size();
        grown.cells.push_back({.key = cells[i].key});
    }
    OctreeOutput& output = grown.arrays;
    const std::vector<std::uint32_t> records =
        PathWriter(cells, elsewhere, output)
            .write(elsewhere == CellsElsewhere::recorded ? all : occupied);
    grown.upper_records = static_cast<std::uint32_t>(output.nodes.size());

    begin_stage(progress, "octree", references);
    SubtreeGrower grower(limits);
    FastChildTest test(snapped);
    for (std::size_t i = 0; i < occupied.size(); ++i) {
        const CellTriangles& cell = cells[occupied[i]];
        const auto* const ids = reinterpret_cast<const std::uint32_t*>(cell.triangles.data());
        const auto root = grower.grow(
            {grid_corner(cell.key), depth(cell.key), {ids, cell.triangles.size()}}, test, output);
        if (!root) return tl::unexpected(root.error());
        output.nodes[records[i]] = *root;
        grown.cells[occupied[i]] = {cell.key, records[i], CellClass::boundary};
        advance_stage(progress, cell.triangles.size());
        if (is_cancelled(progress)) return cancelled("growing cells");
    }
    grown.split_pairs = grower.split_pairs();
    output.nodes.shrink_to_fit();
    output.references.shrink_to_fit();
    return grown;
}

} // namespace

Result<GrownPart> grow_part(const TriangleMesh& mesh, const OctreeFrame& frame,
                            std::span<const CellTriangles> cells, CellsElsewhere elsewhere,
                            const GrowCellsOptions& options)
{
    try {
        return grow_unguarded(mesh, frame, cells, elsewhere, options);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded,
                    "memory ran out: lower the depth, raise the threshold or set a budget");
    }
}

Result<GrownCells> grow_cells(const TriangleMesh& mesh, const OctreeFrame& frame,
                              std::span<const CellTriangles> cells, const GrowCellsOptions& options)
{
    auto part = grow_part(mesh, frame, cells, CellsElsewhere::unrecorded, options);
    if (!part) return tl::unexpected(part.error());
    const auto output = std::make_shared<OctreeOutput>(std::move(part->arrays));
    GrownCells grown;
    grown.octree = Octree::adopt(frame, part_parameters(options), mesh.triangle_count(),
                                 output->nodes.span(), output->references.span(), output);
    grown.cells = std::move(part->cells);
    return grown;
}

} // namespace proxima
