#include "distributed/load_part.h"

#include "base/hash.h"
#include "distributed/slice_reader.h"
#include "octree/distribute_children.h"
#include "octree/octree_file.h"

#include <algorithm>
#include <bit>
#include <memory>

namespace proxima {

namespace {

/// Reads the nodes of a file, which may say anything, without leaving its arrays.
class PartLoader {
public:
    PartLoader(const Octree& file, std::string name, Progress& progress)
        : file_(file), name_(std::move(name)), progress_(progress)
    {}

    /// The cells that ranks share, in Morton order.
    Result<std::vector<Cell>> cells(int routing_depth)
    {
        std::vector<Cell> cells;
        std::vector<Cell> pending = {file_.root()};
        while (!pending.empty()) {
            const Cell cell = pending.back();
            pending.pop_back();
            if (const Status status = check(cell); !status) return tl::unexpected(status.error());
            if (file_.is_leaf(cell) || depth(cell.key) == routing_depth) {
                cells.push_back(cell);
                continue;
            }
            ++above_;
            for (int octant = 7; octant >= 0; --octant) {
                pending.push_back(file_.child(cell, octant));
            }
        }
        return cells;
    }

    /// References of the cell and below it.
    Result<std::uint64_t> count(const Cell& cell)
    {
        std::uint64_t references = 0;
        const Status status = visit(cell, [&](const Cell& leaf) {
            references += file_.triangles(leaf).size();
            return Status{};
        });
        if (!status) return tl::unexpected(status.error());
        return references;
    }

    /// Copies what is below the cell, whose own node goes to output.nodes[record].
    Status copy(const Cell& cell, std::uint32_t record, OctreeOutput& output)
    {
        struct Pending {
            Cell from;
            std::uint32_t record;
        };
        std::vector<Pending> pending = {{cell, record}};
        while (!pending.empty()) {
            const Pending top = pending.back();
            pending.pop_back();
            if (Status status = check(top.from); !status) return status;
            const OctreeNode node = file_.nodes()[top.from.node];
            ++nodes_;
            if (node.is_leaf()) {
                const auto list = file_.triangles(top.from);
                if (Status status = check_list(list); !status) return status;
                output.nodes[top.record] = OctreeNode::leaf(
                    static_cast<std::uint32_t>(output.references.size()), node.count());
                for (const TriangleId id : list) output.references.push_back(id);
                references_ += list.size();
                continue;
            }
            auto first = static_cast<std::uint32_t>(output.nodes.size());
            output.nodes[top.record] =
                OctreeNode::split(first, node.recorded_mask(), node.inner_mask());
            for (int octant = 0; octant < 8; ++octant) {
                const Cell below = file_.child(top.from, octant);
                if (below.node == Cell::no_node) continue;
                output.nodes.push_back(OctreeNode{});
                pending.push_back({below, first++});
            }
            if (is_cancelled(&progress_)) return cancelled("loading the octree", name_);
        }
        return {};
    }

    [[nodiscard]] std::uint64_t above() const noexcept { return above_; }
    [[nodiscard]] std::uint64_t nodes() const noexcept { return nodes_; }
    [[nodiscard]] std::uint64_t references() const noexcept { return references_; }

    [[nodiscard]] tl::unexpected<Error> damaged(const char* what) const
    {
        return fail(ErrorCode::malformed_file, concat("the file contradicts itself: ", what),
                    name_);
    }

private:
    template <class VisitLeaf>
    Status visit(const Cell& cell, const VisitLeaf& visit_leaf)
    {
        std::vector<Cell> pending = {cell};
        while (!pending.empty()) {
            const Cell top = pending.back();
            pending.pop_back();
            if (Status status = check(top); !status) return status;
            if (file_.is_leaf(top)) {
                if (Status status = visit_leaf(top); !status) return status;
                continue;
            }
            for (int octant = 0; octant < 8; ++octant) {
                const Cell below = file_.child(top, octant);
                if (below.node != Cell::no_node) pending.push_back(below);
            }
            if (is_cancelled(&progress_)) return cancelled("loading the octree", name_);
        }
        return {};
    }

    /// Whether the cell's node, its list and its children's nodes are in the arrays, and it is not
    /// too deep. Cells that belong to several parents would be visited over and over.
    Status check(const Cell& cell)
    {
        if (cell.node == Cell::no_node) return {};
        if (++visited_ > 3 * file_.nodes().size()) return damaged("nodes have several parents");
        const OctreeNode node = file_.nodes()[cell.node];
        if (node.is_leaf()) {
            if (node.is_empty()) return damaged("an empty leaf has a record");
            if (std::uint64_t{node.first} + node.count() <= file_.references().size()) return {};
            return damaged("a list ends behind all references");
        }
        if (depth(cell.key) >= file_.parameters().max_depth) return damaged("a cell is too deep");
        const auto children = static_cast<std::uint64_t>(std::popcount(node.recorded_mask()));
        if (children == 0 || (node.packed & ~0xFFFFU) != 0) return damaged("a split cell is none");
        if (node.first + children <= file_.nodes().size()) return {};
        return damaged("children lie behind all nodes");
    }

    [[nodiscard]] Status check_list(std::span<const TriangleId> list) const
    {
        for (std::size_t i = 0; i < list.size(); ++i) {
            if (to_index(list[i]) >= file_.triangle_count()) return damaged("a triangle is none");
            if (i > 0 && list[i] <= list[i - 1]) return damaged("a list does not ascend");
        }
        return {};
    }

    const Octree& file_;
    std::string name_;
    Progress& progress_;
    std::uint64_t visited_ = 0;
    std::uint64_t above_ = 0; ///< nodes above the cells
    std::uint64_t nodes_ = 0; ///< of the cells that were copied, and below
    std::uint64_t references_ = 0;
};

Result<Octree> open(const std::filesystem::path& path, World& world)
{
    // The first bytes have the checksums of all others.
    SharedFile shared(path.string());
    Status status = check_file(shared, path.string(), world);
    if (!status) return tl::unexpected(status.error());
    Octree file;
    const auto open_it = [&](Verification verification) -> Status {
        auto loaded = load_unchecked_octree(
            path, {verification, FileAccess::map, {.progress = &world.progress()}});
        if (!loaded) return tl::unexpected(loaded.error());
        file = std::move(*loaded);
        const auto& parameters = file.parameters();
        if (parameters.subdivision == Subdivision::uniform) {
            return fail(ErrorCode::unsupported_format,
                        "uniform octrees are not spread over processes: use proxima octree",
                        path.string());
        }
        if (file.nodes().empty() || !file.frame().lower.allFinite() ||
            !file.frame().edge.allFinite() || !(file.frame().edge.minCoeff() > 0)) {
            return fail(ErrorCode::malformed_file, "the octree's parameters are damaged",
                        path.string());
        }
        return {};
    };
    status = world.agree_on(
        [&] { return open_it(world.rank() == 0 ? Verification::full : Verification::structure); });
    if (!status) return tl::unexpected(status.error());
    return file;
}

/// What ranks must have in common to share the cells of a file, which may change while it is read.
std::uint64_t hash_of(const Octree& file, const std::vector<Cell>& cells)
{
    const OctreeFrame& frame = file.frame();
    std::vector<std::uint64_t> numbers = {file.nodes().size(), file.references().size(),
                                          file.triangle_count()};
    for (const Vec3& at : {frame.lower, frame.edge})
        for (const double number : at) numbers.push_back(std::bit_cast<std::uint64_t>(number));
    for (const Cell& cell : cells) numbers.push_back(cell.key.bits);
    return hash_bytes(std::as_bytes(std::span(numbers)), 0);
}

/// The cells of this rank when all are shared by their weights. Collective.
Result<std::vector<Cell>> share_cells(const std::vector<Cell>& cells, PartLoader& loader,
                                      World& world)
{
    const Share counted = share_of(cells.size(), world.rank(), world.size());
    std::vector<std::uint64_t> own;
    Status status = world.agree_on([&]() -> Status {
        for (std::uint64_t i = counted.first; i < counted.end; ++i) {
            const auto count = loader.count(cells[i]);
            if (!count) return tl::unexpected(count.error());
            own.push_back(*count + 1);
        }
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    const auto weights = world.all_gather(own);
    if (!weights) return tl::unexpected(weights.error());
    std::uint64_t total = 0;
    for (const std::uint64_t weight : weights->items) total += weight;
    std::vector<Cell> shared;
    std::uint64_t before = 0;
    const auto ranks = static_cast<std::uint64_t>(world.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::uint64_t middle = before + weights->items[i] / 2;
        before += weights->items[i];
        const std::uint64_t rank = std::min(middle / (total / ranks + 1), ranks - 1);
        if (rank == static_cast<std::uint64_t>(world.rank())) shared.push_back(cells[i]);
    }
    return shared;
}

} // namespace

Result<OctreePart> load_part(const std::filesystem::path& path, int routing_depth, World& world)
{
    const auto file = open(path, world);
    if (!file) return tl::unexpected(file.error());
    PartLoader loader(*file, path.string(), world.progress());
    std::vector<Cell> all;
    std::uint64_t hash = 0;
    Status status = world.agree_on([&]() -> Status {
        auto found = loader.cells(routing_depth);
        if (!found) return tl::unexpected(found.error());
        all = std::move(*found);
        hash = hash_of(*file, all);
        return {};
    });
    if (status) status = world.expect_same(hash, path.string());
    if (!status) return tl::unexpected(status.error());
    auto cells = share_cells(all, loader, world);
    if (!cells) return tl::unexpected(cells.error());
    const auto output = std::make_shared<OctreeOutput>();
    OctreePart part;
    status = world.agree_on([&]() -> Status {
        for (const Cell& cell : *cells) {
            part.upper_records += cell.node == Cell::no_node ? 0 : 1;
        }
        for (std::uint32_t i = 0; i < part.upper_records; ++i) output->nodes.push_back({});
        std::uint32_t record = 0;
        for (Cell& cell : *cells) {
            if (cell.node == Cell::no_node) continue;
            if (Status copied = loader.copy(cell, record, *output); !copied) return copied;
            cell.node = record++;
        }
        return {};
    });
    if (!status) return tl::unexpected(status.error());
    const bool is_whole = world.sum(loader.nodes()) + loader.above() == file->nodes().size() &&
                          world.sum(loader.references()) == file->references().size();
    if (!is_whole) return tl::unexpected(loader.damaged("nodes or references of no cell"));
    part.cells = std::move(*cells);
    part.whole_triangles = file->triangle_count();
    part.octree = Octree::adopt(file->frame(), file->parameters(), file->triangle_count(),
                                output->nodes.span(), output->references.span(), output);
    return part;
}

} // namespace proxima
