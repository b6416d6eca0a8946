#include "distributed/save_part.h"

#include "octree/octree_file.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace proxima {

namespace {

/// A cell and its node, with offsets in the whole file.
struct SavedCell {
    CellKey key;
    OctreeNode node;            ///< where it has triangles
    std::uint32_t is_empty = 0; ///< 0 or 1
    std::uint32_t is_inner = 0; ///< 0 or 1
};

/// The nodes from the root down to the cells.
class UpperTree {
public:
    [[nodiscard]] static std::vector<OctreeNode> make(std::span<const SavedCell> cells)
    {
        UpperTree tree;
        tree.nodes_.push_back(OctreeNode{});
        tree.descend(CellKey{}, 0, cells);
        return std::move(tree.nodes_);
    }

private:
    static std::uint64_t morton_end(CellKey key, int level) noexcept
    {
        const int above = depth(key);
        const std::uint64_t morton = key.bits ^ std::uint64_t{1} << (3 * above);
        return (morton + 1) << (3 * (level - above));
    }

    void descend(CellKey key, std::uint32_t record, std::span<const SavedCell> cells)
    {
        if (cells.front().key == key) {
            nodes_[record] = cells.front().node;
            return;
        }
        struct Part {
            CellKey key;
            std::span<const SavedCell> cells;
        };
        std::array<Part, 8> parts;
        std::size_t count = 0;
        std::uint32_t recorded = 0;
        std::uint32_t inner = 0;
        for (int octant = 0; octant < 8; ++octant) {
            const CellKey below = child(key, octant);
            const auto behind = std::ranges::partition_point(cells, [&](const SavedCell& cell) {
                return morton_end(cell.key, max_octree_depth) <=
                       morton_end(below, max_octree_depth);
            });
            const auto here = cells.first(static_cast<std::size_t>(behind - cells.begin()));
            cells = cells.subspan(here.size());
            const std::uint32_t bit = 1U << static_cast<unsigned>(octant);
            if (here.front().key == below && here.front().is_empty != 0) {
                if (here.front().is_inner != 0) inner |= bit;
                continue;
            }
            recorded |= bit;
            parts[count++] = {below, here};
        }
        const auto first = static_cast<std::uint32_t>(nodes_.size());
        nodes_[record] = OctreeNode::split(first, recorded, inner);
        nodes_.resize(nodes_.size() + count);
        for (std::size_t i = 0; i < count; ++i) {
            descend(parts[i].key, first + static_cast<std::uint32_t>(i), parts[i].cells);
        }
    }

    std::vector<OctreeNode> nodes_;
};

class PartSaver {
public:
    PartSaver(const OctreePart& part, const std::filesystem::path& path, World& world)
        : part_(part), path_(path), world_(world)
    {}

    Status run()
    {
        Status status = place();
        if (!status) return status;
        auto cells = world_.collect(saved_cells());
        if (!cells) return tl::unexpected(cells.error());
        status = world_.agree_on([&] { return begin(cells->items); });
        if (!status) return status;
        const auto lower = part_.octree.nodes().subspan(part_.upper_records);
        stream<OctreeNode>(lower.size(), [&](std::size_t i) { return moved(lower[i]); });
        const auto references = part_.octree.references();
        stream<std::uint32_t>(references.size(), [&](std::size_t i) {
            return static_cast<std::uint32_t>(part_.whole_id(references[i]));
        });
        return world_.agree_on_done([&]() -> Status {
            if (!writer_ || !written_) return written_;
            return writer_->commit();
        });
    }

private:
    /// Where this rank's nodes and references go.
    Status place()
    {
        std::uint64_t occupied = 0;
        for (const Cell& cell : part_.cells) occupied += cell.node == Cell::no_node ? 0 : 1;
        const std::uint64_t lower = part_.octree.nodes().size() - part_.upper_records;
        const std::uint64_t references = part_.octree.references().size();
        // Every node but the root is of an octant with triangles.
        upper_ = (world_.sum(part_.cells.size()) - 1) / 7 + world_.sum(occupied);
        node_count_ = upper_ + world_.sum(lower);
        reference_count_ = world_.sum(references);
        first_node_ = upper_ + world_.sum_before(lower);
        first_reference_ = world_.sum_before(references);
        constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
        if (node_count_ < most && reference_count_ <= most &&
            part_.whole_triangles <= std::numeric_limits<std::int32_t>::max()) {
            return {};
        }
        return fail(ErrorCode::limit_exceeded,
                    concat("the octree has ", node_count_, " nodes, ", reference_count_,
                           " references and ", part_.whole_triangles,
                           " triangles: a .pxo file has at most 2^32 of each, and 2^31 triangles"),
                    path_.string());
    }

    /// A node of this rank as the file has it.
    [[nodiscard]] OctreeNode moved(OctreeNode node) const noexcept
    {
        node.first = static_cast<std::uint32_t>(node.is_leaf() ? node.first + first_reference_
                                                               : node.first + first_node_ -
                                                                     part_.upper_records);
        return node;
    }

    [[nodiscard]] std::vector<SavedCell> saved_cells() const
    {
        std::vector<SavedCell> cells;
        for (const Cell& cell : part_.cells) {
            SavedCell& saved = cells.emplace_back();
            saved.key = cell.key;
            if (cell.node == Cell::no_node) {
                saved.is_empty = 1;
                saved.is_inner = cell.type == CellClass::inner ? 1 : 0;
            } else {
                saved.node = moved(part_.octree.nodes()[cell.node]);
            }
        }
        return cells;
    }

    /// On rank 0, everything before the first rank's nodes.
    Status begin(const std::vector<SavedCell>& cells)
    {
        if (world_.rank() != 0) return {};
        const OctreeFileHeader header = octree_file_header(
            part_.octree.frame(), part_.octree.parameters(), part_.whole_triangles);
        const std::array<SectionSize, 3> sections = {
            SectionSize{header_section, sizeof header, sizeof header},
            SectionSize{nodes_section, sizeof(OctreeNode), node_count_ * sizeof(OctreeNode)},
            SectionSize{references_section, sizeof(TriangleId),
                        reference_count_ * sizeof(TriangleId)}};
        auto writer = BinaryFileWriter::create(path_, octree_format, sections, &world_.progress());
        if (!writer) return tl::unexpected(writer.error());
        writer_.emplace(std::move(*writer));
        if (auto status = writer_->write(std::as_bytes(std::span(&header, 1))); !status) {
            return status;
        }
        const std::vector<OctreeNode> upper = UpperTree::make(cells);
        return writer_->write(std::as_bytes(std::span(upper)));
    }

    /// All ranks' items, item_at(i) of this one, to the file. What cannot be written is thrown away.
    template <class Item, class ItemAt>
    void stream(std::size_t count, const ItemAt& item_at)
    {
        std::vector<Item> items;
        world_.stream_to_first<Item>(
            count,
            [&](std::size_t first, std::size_t end) {
                items.clear();
                for (std::size_t i = first; i < end; ++i) items.push_back(item_at(i));
                return std::span<const Item>(items);
            },
            [&](std::span<const Item> part) {
                if (written_) written_ = writer_->write(std::as_bytes(part));
            });
    }

    const OctreePart& part_;
    const std::filesystem::path& path_;
    World& world_;
    std::uint64_t upper_ = 0; ///< nodes of the root, the cells and what is between
    std::uint64_t node_count_ = 0;
    std::uint64_t reference_count_ = 0;
    std::uint64_t first_node_ = 0;
    std::uint64_t first_reference_ = 0;
    std::optional<BinaryFileWriter> writer_; ///< on rank 0
    Status written_;
};

} // namespace

Status save_part(const OctreePart& part, const std::filesystem::path& path, World& world)
{
    return PartSaver(part, path, world).run();
}

} // namespace proxima
