#include "proxima/mesh_index.h"

#include "base/memory_budget.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "index/index_parts.h"
#include "index/slabs/block_slab.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace proxima {

namespace {

// How far slabs are drawn out, in units of the blocks: what the vertices' rounding to floats takes
// (u = 2^-24 on each axis), that of boxes' centers as lanes read them (6 u), and e's own.
constexpr double slab_margin = 16 * 0x1p-24;
constexpr std::size_t blocks_per_task = 64;
constexpr std::size_t lanes = 8;
constexpr int normal_unit = 512;
constexpr int extent_unit = 32768;

std::uint32_t bits_of(double value, int most, unsigned bits)
{
    const double whole = std::clamp(value, -static_cast<double>(most), static_cast<double>(most));
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(whole)) & ((1U << bits) - 1);
}

class SlabWriter {
public:
    /// A block and the box that its node draws round it.
    struct BoxedBlock {
        std::uint32_t reference;
        Vec3 center;
        Vec3 half;
    };

    explicit SlabWriter(const IndexParts& index)
        : index_(index), blocks_(index.blocks()),
          slabs_(std::make_shared<std::vector<BlockSlab>>(blocks_.size() + lanes - 1))
    {}

    bool write(Threads threads, Progress* progress)
    {
        std::vector<BoxedBlock> found;
        found.reserve(blocks_.size());
        constexpr double root_half = 1.01; // as the search begins with
        if (index_.triangle_count() > 0)
            found.push_back({index_.root(), Vec3::Zero(), Vec3::Constant(root_half)});
        for (std::size_t i = 0; i < found.size(); ++i) add_children(found[i].reference, found);
        begin_stage(progress, "fitting slabs", found.size());
        parallel_chunks(found.size(), blocks_per_task, threads,
                        [&](std::size_t first, std::size_t end) {
                            if (is_cancelled(progress)) return;
                            for (std::size_t i = first; i < end; ++i)
                                (*slabs_)[found[i].reference & ~index_leaf_bit] = slab_of(found[i]);
                            advance_stage(progress, end - first);
                        });
        return !is_cancelled(progress);
    }

    MeshIndex result() { return make_mesh_index(index_.adopt_slabs(*slabs_, slabs_)); }

private:
    [[nodiscard]] bool is_empty(std::uint32_t reference) const
    {
        return (reference & index_leaf_bit) != 0 &&
               blocks_[reference & ~index_leaf_bit].leaf.count == 0;
    }

    void add_children(std::uint32_t reference, std::vector<BoxedBlock>& found) const
    {
        if ((reference & index_leaf_bit) != 0) return;
        const IndexNode& node = blocks_[reference].node;
        for (std::size_t slot = 0; slot < lanes; ++slot) {
            if (is_empty(node.children[slot])) continue;
            BoxedBlock child = {node.children[slot], {}, {}};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double origin = double{node.origin[axis]} + 32768 * double{node.step[axis]};
                const double half_step = 0.5 * double{node.step[axis]};
                const int lower = node.planes[axis][slot];
                const int upper = node.planes[axis][lanes + slot];
                const auto k = static_cast<Eigen::Index>(axis);
                child.center[k] = origin + half_step * (lower + upper);
                child.half[k] = half_step * (upper - lower);
            }
            found.push_back(child);
        }
    }

    /// Calls visit(point) for every vertex below, those of several leaves several times.
    template <class Visit>
    void visit_vertices(std::uint32_t reference, const Visit& visit) const
    {
        if ((reference & index_leaf_bit) == 0) {
            for (const std::uint32_t child : blocks_[reference].node.children)
                if (!is_empty(child)) visit_vertices(child, visit);
            return;
        }
        const IndexLeaf& leaf = blocks_[reference & ~index_leaf_bit].leaf;
        for (std::size_t i = 0; i < lanes; ++i) {
            visit(Vec3(double{leaf.coordinates[0][i]}, double{leaf.coordinates[1][i]},
                       double{leaf.coordinates[2][i]}));
        }
    }

    /// Across the direction in which the vertices are spread least.
    [[nodiscard]] BlockSlab slab_of(const BoxedBlock& block) const
    {
        Vec3 sum = Vec3::Zero();
        double count = 0;
        visit_vertices(block.reference, [&](const Vec3& p) {
            sum += p;
            count += 1;
        });
        const Vec3 mean = sum / count;
        Mat3 spread = Mat3::Zero();
        visit_vertices(block.reference, [&](const Vec3& p) {
            const Vec3 from_mean = p - mean;
            spread += from_mean * from_mean.transpose();
        });
        Eigen::SelfAdjointEigenSolver<Mat3> solver;
        solver.computeDirect(spread);
        const Vec3 across = solver.eigenvectors().col(0);
        BlockSlab slab;
        Vec3 normal;
        for (int k = 0; k < 3; ++k) {
            const double number = std::round(across[k] * normal_unit);
            normal[k] = std::clamp(number, 1.0 - normal_unit, normal_unit - 1.0) / normal_unit;
            slab.normal |= bits_of(number, normal_unit - 1, 10) << (22 - 10 * k);
        }
        double lower = std::numeric_limits<double>::infinity();
        double upper = -lower;
        visit_vertices(block.reference, [&](const Vec3& p) {
            const double on = normal.dot(p - block.center);
            lower = std::min(lower, on);
            upper = std::max(upper, on);
        });
        const double unit = normal.cwiseAbs().dot(block.half) / extent_unit;
        const double up = std::ceil((upper + slab_margin) / unit);
        const double down = std::floor((lower - slab_margin) / unit);
        slab.extent = bits_of(up, extent_unit - 1, 16) << 16U | bits_of(down, extent_unit - 1, 16);
        return slab;
    }

    const IndexParts& index_;
    std::span<const IndexBlock> blocks_;
    std::shared_ptr<std::vector<BlockSlab>> slabs_;
};

} // namespace

Result<MeshIndex> with_slabs(const MeshIndex& index, const SlabOptions& options)
{
    const std::uint64_t needed =
        index.parts().blocks().size() * (sizeof(BlockSlab) + sizeof(SlabWriter::BoxedBlock));
    if (auto status = check_budget(options.execution.budget, needed, "slabs of a mesh index",
                                   "raise the budget");
        !status)
        return tl::unexpected(status.error());
    SlabWriter writer(index.parts());
    if (!writer.write(options.execution.threads, options.execution.progress))
        return cancelled("fitting slabs");
    return writer.result();
}

} // namespace proxima
