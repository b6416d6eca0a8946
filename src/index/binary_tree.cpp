#include "index/binary_tree.h"

#include "base/fixed_stack.h"
#include "base/morton_code.h"
#include "base/radix_sort.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr std::size_t triangles_per_task = 4096;
constexpr std::uint64_t beyond_float = (1U << 29U) - 1; // bits that floats have no room for
constexpr float float_infinity = std::numeric_limits<float>::infinity();

bool has_floats(const TriangleMesh& mesh) noexcept
{
    return std::ranges::all_of(mesh.positions(), [](const Vec3& p) {
        return is_float(p.x()) && is_float(p.y()) && is_float(p.z());
    });
}

/// Where floats count from so that they stay floats: from zero, unless the ends are within a factor
/// of two of each other; then the difference of any two between them is exact.
double float_center(double lower, double upper) noexcept
{
    const bool is_far = (lower > 0 && upper <= 2 * lower) || (upper < 0 && 2 * upper <= lower);
    const double middle = 0.5 * lower + 0.5 * upper;
    return is_far ? std::bit_cast<double>(std::bit_cast<std::uint64_t>(middle) & ~beyond_float) : 0;
}

} // namespace

IndexFrame index_frame(const Box& box, bool has_floats) noexcept
{
    IndexFrame frame;
    frame.center = box.center();
    for (int axis = 0; has_floats && axis < 3; ++axis)
        frame.center[axis] = float_center(box.lower[axis], box.upper[axis]);
    const double reach =
        std::max((box.upper - frame.center).maxCoeff(), (frame.center - box.lower).maxCoeff());
    if (reach > 0) frame.scale = std::ldexp(1.0, std::clamp(-std::ilogb(reach) - 1, -1000, 1000));
    return frame;
}

namespace {

/// The cell of the deepest grid in which a point lies.
std::uint64_t place_of(const Vec3& point, const OctreeFrame& root) noexcept
{
    constexpr double cells = 1U << morton_bits;
    std::array<std::uint32_t, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const double cell = (point[k] - root.lower[k]) / root.edge[k] * cells;
        at[axis] = static_cast<std::uint32_t>(std::clamp(cell, 0.0, cells - 1));
    }
    return morton_code(at);
}

FloatBox union_of(const FloatBox& a, const FloatBox& b) noexcept
{
    FloatBox box{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(a.lower[axis], b.lower[axis]);
        box.upper[axis] = std::max(a.upper[axis], b.upper[axis]);
    }
    return box;
}

// The steps of build_binary_tree, in the order of their calls there.
class RayTreeBuilder {
public:
    RayTreeBuilder(const TriangleMesh& mesh, const Box& box, const OctreeFrame& root,
                   Threads threads, Progress* progress)
        : mesh_(mesh), root_(root), threads_(threads), progress_(progress)
    {
        tree_.has_floats = has_floats(mesh);
        tree_.frame = index_frame(box, tree_.has_floats);
    }

    bool sort_triangles()
    {
        const std::size_t count = mesh_.triangle_count();
        keys_.resize(count);
        for_triangles([&](std::uint32_t i) {
            const Box box = bounding_box(mesh_.triangle(TriangleId{i}));
            keys_[i] = {place_of(box.center(), root_), i};
        });
        constexpr unsigned key_bits = 3 * morton_bits;
        StageSteps steps(progress_, "sorting triangles", count * radix_passes(key_bits));
        if (!radix_sort(keys_, key_bits, steps)) return false;
        tree_.order.resize(count);
        tree_.boxes.resize(count);
        for_triangles([&](std::uint32_t i) {
            const TriangleId id{keys_[i].index};
            tree_.order[i] = id;
            const Box box = bounding_box(mesh_.triangle(id));
            const Vec3 lower = tree_.frame.to_frame(box.lower);
            const Vec3 upper = tree_.frame.to_frame(box.upper);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<Eigen::Index>(axis);
                tree_.boxes[i].lower[axis] = static_cast<float>(lower[k]);
                tree_.boxes[i].upper[axis] = static_cast<float>(upper[k]);
            }
        });
        return !is_cancelled(progress_);
    }

    bool cut_runs()
    {
        struct Run {
            std::uint32_t first;
            std::uint32_t count;
        };
        const auto count = static_cast<std::uint32_t>(keys_.size());
        tree_.nodes.reserve(count - 1);
        StageSteps steps(progress_, "cutting cells", count);
        // Of every node on the way down the right child waits: one per bit of place and rank.
        FixedStack<Run, 3 * morton_bits + 32> pending;
        if (count > 1) pending.push({0, count});
        while (!pending.empty()) {
            const Run run = pending.pop();
            const std::uint32_t left = left_count(run.first, run.count);
            BinaryNode node;
            node.first = run.first;
            node.count = run.count;
            node.left_count = left;
            tree_.nodes.push_back(node);
            if (run.count - left > 1) pending.push({run.first + left, run.count - left});
            if (left > 1) pending.push({run.first, left});
            if (!steps.done(1)) return false;
        }
        keys_ = {};
        return true;
    }

    bool find_costs()
    {
        StageSteps steps(progress_, "weighing cells", tree_.nodes.size());
        for (auto node = static_cast<std::uint32_t>(tree_.nodes.size()); node-- > 0;) {
            find_cost(node);
            if (!steps.done(1)) return false;
        }
        return true;
    }

    BinaryTree result() { return std::move(tree_); }

private:
    template <class Body>
    void for_triangles(const Body& body)
    {
        const std::size_t count = mesh_.triangle_count();
        parallel_for((count + triangles_per_task - 1) / triangles_per_task, threads_,
                     [&](std::size_t task) {
                         const std::size_t end = std::min(count, (task + 1) * triangles_per_task);
                         for (std::size_t i = task * triangles_per_task; i < end; ++i)
                             body(static_cast<std::uint32_t>(i));
                     });
    }

    /// How many of a run lie before its highest differing bit changes.
    [[nodiscard]] std::uint32_t left_count(std::uint32_t first, std::uint32_t count) const
    {
        const std::uint64_t differing = keys_[first].key ^ keys_[first + count - 1].key;
        if (differing == 0) return count / 2;
        const std::uint64_t bit = std::bit_floor(differing);
        const auto begin = keys_.begin() + first;
        const auto cut = std::partition_point(
            begin, begin + count, [&](const KeyedIndex& item) { return (item.key & bit) == 0; });
        return static_cast<std::uint32_t>(cut - begin);
    }

    [[nodiscard]] bool fits_leaf(const BinaryNode& node) const
    {
        if (node.count > index_width) return false;
        std::array<std::uint32_t, index_width> seen{};
        std::size_t vertices = 0;
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            for (const std::uint32_t corner : mesh_.triangles()[index(tree_.order[i])]) {
                const auto end = seen.begin() + static_cast<std::ptrdiff_t>(vertices);
                if (std::find(seen.begin(), end, corner) != end) continue;
                if (vertices == index_width) return false;
                seen[vertices++] = corner;
            }
        }
        return true;
    }

    void find_cost(std::uint32_t at)
    {
        BinaryNode& node = tree_.nodes[at];
        const auto [left, right] = tree_.children(at);
        node.box = union_of(tree_.box(left), tree_.box(right));
        std::array<float, index_width> apart{}; // covered by at most k, not by itself
        apart[0] = float_infinity;
        for (std::uint32_t k = 2; k <= index_width; ++k) {
            float least = float_infinity;
            for (std::uint32_t i = 1; i < k; ++i)
                least = std::min(least, tree_.cost(left, i) + tree_.cost(right, k - i));
            apart[k - 1] = least;
        }
        const float area = node.box.half_area();
        const float as_node = area + apart[index_width - 1];
        node.is_leaf = area <= as_node && fits_leaf(node);
        node.cost[0] = node.is_leaf ? area : as_node;
        for (std::size_t k = 1; k < index_width; ++k)
            node.cost[k] = std::min(node.cost[0], apart[k]);
    }

    const TriangleMesh& mesh_;
    const OctreeFrame& root_;
    Threads threads_;
    Progress* progress_;
    std::vector<KeyedIndex> keys_;
    BinaryTree tree_;
};

} // namespace

// By its bits: g++ 12 drops the rounding of a conversion there and back where it makes vectors of
// it.
bool is_float(double value) noexcept
{
    const double size = std::abs(value);
    return size == 0 || ((std::bit_cast<std::uint64_t>(value) & beyond_float) == 0 &&
                         size >= static_cast<double>(std::numeric_limits<float>::min()) &&
                         size <= static_cast<double>(std::numeric_limits<float>::max()));
}

BinaryTree::Child BinaryTree::root() const noexcept
{
    return {0, 0, static_cast<std::uint32_t>(order.size())};
}

std::array<BinaryTree::Child, 2> BinaryTree::children(std::uint32_t node) const noexcept
{
    const BinaryNode& at = nodes[node];
    // A run of n triangles has n - 1 nodes.
    return {{{node + 1, at.first, at.left_count},
             {node + at.left_count, at.first + at.left_count, at.count - at.left_count}}};
}

float BinaryTree::cost(const Child& child, std::uint32_t most) const noexcept
{
    return child.count == 1 ? boxes[child.first].half_area() : nodes[child.node].cost[most - 1];
}

std::uint32_t BinaryTree::left_share(std::uint32_t node, std::uint32_t most) const noexcept
{
    const auto [left, right] = children(node);
    std::uint32_t best = 1;
    for (std::uint32_t i = 2; i < most; ++i) {
        if (cost(left, i) + cost(right, most - i) < cost(left, best) + cost(right, most - best))
            best = i;
    }
    return best;
}

Result<BinaryTree> build_binary_tree(const TriangleMesh& mesh, const Box& box,
                                     const OctreeFrame& root, Threads threads, Progress* progress)
{
    RayTreeBuilder builder(mesh, box, root, threads, progress);
    if (!builder.sort_triangles() || !builder.cut_runs() || !builder.find_costs())
        return fail(ErrorCode::cancelled, "mesh index: stopped on request");
    return builder.result();
}

} // namespace proxima
