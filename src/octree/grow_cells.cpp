#include "proxima/grow_cells.h"

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
        const Status status = check_list(cells[i], i, triangle_count);
        if (!status) return status;
    }
    return {};
}

/// Splits the root down to the cells that have triangles.
class PathWriter {
public:
    PathWriter(std::span<const CellTriangles> cells, OctreeOutput& output) noexcept
        : cells_(cells), output_(output)
    {}

    /// records[i] = where cells[occupied[i]] is to go. \pre !occupied.empty()
    void write(std::span<const std::size_t> occupied, std::vector<std::uint32_t>& records)
    {
        output_.nodes.push_back(OctreeNode{});
        descend(CellKey{}, 0, occupied, records);
    }

private:
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
            if (in_child == 0) continue;
            parts[count++] = {below, left.first(in_child)};
            recorded |= 1U << static_cast<unsigned>(octant);
            left = left.subspan(in_child);
        }
        const auto first = static_cast<std::uint32_t>(output_.nodes.size());
        output_.nodes[record] = OctreeNode::split(first, recorded);
        for (std::size_t i = 0; i < count; ++i) output_.nodes.push_back(OctreeNode{});
        for (std::size_t i = 0; i < count; ++i) {
            descend(parts[i].key, first + static_cast<std::uint32_t>(i), parts[i].cells, records);
        }
    }

    std::span<const CellTriangles> cells_;
    OctreeOutput& output_;
};

Result<GrownCells> grow_unguarded(const TriangleMesh& mesh, const OctreeFrame& frame,
                                  std::span<const CellTriangles> cells,
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
    std::vector<std::size_t> occupied;
    std::uint64_t references = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (!cells[i].triangles.empty()) occupied.push_back(i);
        references += cells[i].triangles.size();
    }
    const auto output = std::make_shared<OctreeOutput>();
    std::vector<std::uint32_t> records;
    if (!occupied.empty()) PathWriter(cells, *output).write(occupied, records);

    begin_stage(progress, "octree", references);
    SubtreeGrower grower(limits);
    FastChildTest test(snapped);
    GrownCells grown;
    for (const CellTriangles& cell : cells) grown.cells.push_back({.key = cell.key});
    for (std::size_t i = 0; i < occupied.size(); ++i) {
        const CellTriangles& cell = cells[occupied[i]];
        const auto* const ids = reinterpret_cast<const std::uint32_t*>(cell.triangles.data());
        const auto root = grower.grow(
            {grid_corner(cell.key), depth(cell.key), {ids, cell.triangles.size()}}, test, *output);
        if (!root) return tl::unexpected(root.error());
        output->nodes[records[i]] = *root;
        grown.cells[occupied[i]] = {cell.key, records[i], CellClass::boundary};
        advance_stage(progress, cell.triangles.size());
        if (is_cancelled(progress)) return cancelled("growing cells");
    }
    output->nodes.shrink_to_fit();
    output->references.shrink_to_fit();
    const OctreeParameters parameters{
        .max_depth = options.max_depth, .threshold = options.threshold, .exact = true};
    grown.octree = Octree::adopt(frame, parameters, mesh.triangle_count(), output->nodes.span(),
                                 output->references.span(), output);
    return grown;
}

} // namespace

Result<GrownCells> grow_cells(const TriangleMesh& mesh, const OctreeFrame& frame,
                              std::span<const CellTriangles> cells, const GrowCellsOptions& options)
{
    try {
        return grow_unguarded(mesh, frame, cells, options);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::budget_exceeded,
                    "memory ran out: lower the depth, raise the threshold or set a budget");
    }
}

} // namespace proxima
