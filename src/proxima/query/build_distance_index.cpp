#include "proxima/query/build_distance_index.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <limits>
#include <vector>

namespace proxima {

namespace {

// How far slabs are drawn out, in units of the blocks: vertices were rounded to floats in [-1, 1],
// and lower and upper are once more.
constexpr double slab_margin = 4 * 0x1p-24;
constexpr std::size_t blocks_per_task = 64;
constexpr std::size_t lanes = 8;

struct SlabStorage {
    std::array<std::vector<float>, DistanceIndex::numbers> slabs;
};

} // namespace

class DistanceIndexWriter {
public:
    explicit DistanceIndexWriter(const RayIndex& triangles)
        : triangles_(triangles), blocks_(triangles.blocks()),
          storage_(std::make_shared<SlabStorage>())
    {
        for (auto& numbers : storage_->slabs) numbers.assign(blocks_.size() + lanes, 0.0F);
    }

    bool write(Threads threads, Progress* progress)
    {
        std::vector<std::uint32_t> references;
        references.reserve(blocks_.size());
        if (triangles_.triangle_count() > 0) references.push_back(triangles_.root());
        for (std::size_t i = 0; i < references.size(); ++i) {
            if ((references[i] & ray_leaf_bit) != 0) continue;
            for (const std::uint32_t child : blocks_[references[i]].node.children)
                if (!is_empty(child)) references.push_back(child);
        }
        if (progress != nullptr) progress->begin_stage("fitting slabs", references.size());
        const std::size_t tasks = (references.size() + blocks_per_task - 1) / blocks_per_task;
        parallel_for(tasks, threads, [&](std::size_t task) {
            if (is_cancelled(progress)) return;
            const std::size_t first = task * blocks_per_task;
            const std::size_t end = std::min(references.size(), first + blocks_per_task);
            for (std::size_t i = first; i < end; ++i) fit_slab(references[i]);
            if (progress != nullptr) progress->advance(end - first);
        });
        return !is_cancelled(progress);
    }

    DistanceIndex result()
    {
        DistanceIndex index;
        index.triangles_ = triangles_;
        for (std::size_t i = 0; i < DistanceIndex::numbers; ++i)
            index.slabs_[i] = storage_->slabs[i];
        index.storage_ = std::move(storage_);
        return index;
    }

private:
    [[nodiscard]] bool is_empty(std::uint32_t reference) const
    {
        return (reference & ray_leaf_bit) != 0 &&
               blocks_[reference & ~ray_leaf_bit].leaf.count == 0;
    }

    /// Calls visit(point) for every vertex below, those of several leaves several times.
    template <class Visit>
    void visit_vertices(std::uint32_t reference, const Visit& visit) const
    {
        if ((reference & ray_leaf_bit) == 0) {
            for (const std::uint32_t child : blocks_[reference].node.children)
                if (!is_empty(child)) visit_vertices(child, visit);
            return;
        }
        const RayLeaf& leaf = blocks_[reference & ~ray_leaf_bit].leaf;
        for (std::size_t i = 0; i < lanes; ++i) {
            visit(Vec3(double{leaf.coordinates[0][i]}, double{leaf.coordinates[1][i]},
                       double{leaf.coordinates[2][i]}));
        }
    }

    /// Across the direction in which the vertices are spread least.
    void fit_slab(std::uint32_t reference)
    {
        Vec3 sum = Vec3::Zero();
        double count = 0;
        visit_vertices(reference, [&](const Vec3& p) {
            sum += p;
            count += 1;
        });
        const Vec3 center = sum / count;
        Mat3 spread = Mat3::Zero();
        visit_vertices(reference, [&](const Vec3& p) {
            const Vec3 from_center = p - center;
            spread += from_center * from_center.transpose();
        });
        Eigen::SelfAdjointEigenSolver<Mat3> solver;
        solver.computeDirect(spread);
        const Eigen::Vector3f normal = solver.eigenvectors().col(0).cast<float>();
        double lower = std::numeric_limits<double>::infinity();
        double upper = -lower;
        visit_vertices(reference, [&](const Vec3& p) {
            const double on = normal.cast<double>().dot(p);
            lower = std::min(lower, on);
            upper = std::max(upper, on);
        });
        const std::uint32_t block = reference & ~ray_leaf_bit;
        auto& slabs = storage_->slabs;
        for (std::size_t axis = 0; axis < 3; ++axis)
            slabs[axis][block] = normal[static_cast<Eigen::Index>(axis)];
        slabs[DistanceIndex::lower][block] = static_cast<float>(lower - slab_margin);
        slabs[DistanceIndex::upper][block] = static_cast<float>(upper + slab_margin);
    }

    const RayIndex& triangles_;
    std::span<const RayBlock> blocks_;
    std::shared_ptr<SlabStorage> storage_;
};

Result<DistanceIndex> build_distance_index(const RayIndex& triangles,
                                           const DistanceIndexOptions& options)
{
    const std::uint64_t needed =
        triangles.blocks().size() * (DistanceIndex::numbers * sizeof(float) + 4);
    if (auto status =
            check_budget(options.budget, needed, "the distance index", "raise the budget");
        !status)
        return tl::unexpected(status.error());
    DistanceIndexWriter writer(triangles);
    if (!writer.write(options.threads, options.progress))
        return fail(ErrorCode::cancelled, "distance index: stopped on request");
    return writer.result();
}

} // namespace proxima
