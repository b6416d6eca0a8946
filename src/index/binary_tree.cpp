#include "index/binary_tree.h"

#include "base/fixed_stack.h"
#include "base/morton_code.h"
#include "base/parallel.h"
#include "base/parallel_sort.h"
#include "base/progress.h"
#include "index/row_tables.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr std::size_t triangles_per_task = 4096;
constexpr std::uint64_t beyond_float = (1U << 29U) - 1; // bits that floats lack
constexpr std::uint32_t subtree_triangles = 4096;
constexpr float float_infinity = std::numeric_limits<float>::infinity();

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
    // A point has no size, although its centre may be rounded.
    const bool is_point = (box.upper.array() == box.lower.array()).all();
    if (reach > 0 && !is_point)
        frame.scale = std::ldexp(1.0, std::clamp(-std::ilogb(reach) - 1, -1000, 1000));
    return frame;
}

namespace {

/// The cell of the deepest grid in which a point lies.
std::uint64_t cell_position(const Vec3& point, const OctreeFrame& root) noexcept
{
    constexpr double cells = 1U << morton_bits;
    std::array<std::uint32_t, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        const double cell = (point[k] - root.lower[k]) / root.edge[k] * cells;
        // Not a number where the root's edge is infinite.
        at[axis] = static_cast<std::uint32_t>(cell > 0 ? std::min(cell, cells - 1) : 0.0);
    }
    return morton_code(at);
}

/// How a run is covered, and its vertices while they fit a leaf.
struct Cover {
    /// [k]: by at most k + 1 boxes, the sum of areas that queries look into.
    std::array<float, index_width> costs;
    std::array<std::uint32_t, index_width> vertices; ///< then no_vertex
    std::uint32_t vertex_count;                      ///< index_width + 1: more than fit
    static constexpr std::uint32_t no_vertex = 0xFFFFFFFF;
};

/// The vertices of two runs, each once. Without branches that depend on the mesh.
void unite_vertices(const Cover& left, const Cover& right, Cover& both) noexcept
{
    std::array<std::uint32_t, std::size_t{2} * index_width + 1> united;
    united.fill(Cover::no_vertex);
    std::ranges::copy(left.vertices, united.begin());
    std::uint32_t count = left.vertex_count;
    if (count <= index_width && right.vertex_count <= index_width) {
        for (std::uint32_t i = 0; i < right.vertex_count; ++i) {
            bool is_known = false;
            for (const std::uint32_t known : left.vertices) is_known |= known == right.vertices[i];
            united[count] = right.vertices[i];
            count += is_known ? 0U : 1U;
        }
        united[count] = Cover::no_vertex;
    } else {
        count = index_width + 1;
    }
    std::copy_n(united.begin(), index_width, both.vertices.begin());
    both.vertex_count = std::min(count, index_width + 1);
}

using Run = BinaryTree::Child;

void unite(const FloatBox& a, const FloatBox& b, FloatBox& both) noexcept
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        both.lower[axis] = std::min(a.lower[axis], b.lower[axis]);
        both.upper[axis] = std::max(a.upper[axis], b.upper[axis]);
    }
}

// The steps of build_binary_tree, in the order of their calls there.
class BinaryTreeBuilder {
public:
    BinaryTreeBuilder(const TriangleMesh& mesh, const IndexFrame& frame, const OctreeFrame& root,
                      Threads threads, Progress* progress)
        : mesh_(mesh), root_(root), threads_(threads), progress_(progress)
    {
        tree_.frame = frame;
    }

    bool sort_triangles()
    {
        const std::size_t count = mesh_.triangle_count();
        keys_.resize(count);
        GrowBuffer<FloatBox> boxes; // by id
        boxes.resize(count);
        for_triangles([&](std::uint32_t i) {
            const Box box = bounding_box(mesh_.triangle(TriangleId{i}));
            keys_[i] = {cell_position(box.center(), root_), i};
            const Vec3 lower = tree_.frame.to_frame(box.lower);
            const Vec3 upper = tree_.frame.to_frame(box.upper);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<Eigen::Index>(axis);
                boxes[i].lower[axis] = static_cast<float>(lower[k]);
                boxes[i].upper[axis] = static_cast<float>(upper[k]);
            }
        });
        constexpr unsigned key_bits = 3 * morton_bits;
        if (!sort_keys(keys_, key_bits, threads_, progress_)) return false;
        tree_.order.resize(count);
        tree_.boxes.resize(count);
        for_triangles([&](std::uint32_t i) {
            tree_.order[i] = TriangleId{keys_[i].index};
            tree_.boxes[i] = boxes[keys_[i].index];
        });
        return !is_cancelled(progress_);
    }

    /// Cuts the order into runs and chooses how they are covered: large ones one after the other,
    /// what lies below them side by side.
    bool make_nodes()
    {
        const auto count = static_cast<std::uint32_t>(keys_.size());
        tree_.nodes.resize(count - 1);
        begin_stage(progress_, "cutting cells", count);
        std::vector<Run> runs; // large ones, and the first small ones below them, depth first
        for_each_run(tree_.root(), [&](const Run& run) {
            runs.push_back(run);
            if (run.count <= subtree_triangles) return false;
            cut(run);
            return true;
        });
        std::vector<Cover> covers(runs.size());
        parallel_for(runs.size(), threads_, [&](std::size_t task) {
            const Run& top = runs[task];
            if (top.count > subtree_triangles || is_cancelled(progress_)) return;
            std::vector<Run> below;
            below.reserve(top.count);
            for_each_run(top, [&](const Run& run) {
                below.push_back(run);
                cut(run);
                return true;
            });
            std::vector<Cover> pending;
            for (std::size_t i = below.size(); i-- > 0;) choose_cover(below[i], pending);
            covers[task] = pending.back();
            advance_stage(progress_, top.count);
        });
        if (is_cancelled(progress_)) return false;
        std::vector<Cover> pending;
        for (std::size_t i = runs.size(); i-- > 0;) {
            if (runs[i].count > subtree_triangles) {
                choose_cover(runs[i], pending);
            } else {
                pending.push_back(covers[i]);
            }
        }
        keys_ = {};
        return true;
    }

    BinaryTree result() { return std::move(tree_); }

private:
    /// Depth first, left before right: enters what `visit` says to. \pre it has cut that
    template <class Visit>
    void for_each_run(const Run& top, const Visit& visit)
    {
        // Of every node on the way down the right child waits: one per bit of position and rank.
        FixedStack<Run, 3 * morton_bits + 32> pending;
        if (top.count > 1) pending.push(top);
        while (!pending.empty()) {
            const Run run = pending.pop();
            if (!visit(run)) continue;
            const auto [left, right] = tree_.children(run);
            if (right.count > 1) pending.push(right);
            if (left.count > 1) pending.push(left);
        }
    }

    void cut(const Run& run)
    {
        tree_.nodes[run.node].left_count = left_count(run.first, run.count);
    }

    template <class Body>
    void for_triangles(const Body& body)
    {
        parallel_chunks(mesh_.triangle_count(), triangles_per_task, threads_,
                        [&](std::size_t first, std::size_t end) {
                            for (auto i = static_cast<std::uint32_t>(first); i < end; ++i) body(i);
                        });
    }

    /// How many of a run lie before its highest differing bit changes.
    [[nodiscard]] std::uint32_t left_count(std::uint32_t first, std::uint32_t count) const
    {
        const std::uint64_t differing = keys_[first].key ^ keys_[first + count - 1].key;
        if (differing == 0) return count / 2;
        const std::uint64_t bit = std::bit_floor(differing);
        const KeyedIndex* const begin = keys_.data() + first;
        const KeyedIndex* const cut = std::partition_point(
            begin, begin + count, [&](const KeyedIndex& item) { return (item.key & bit) == 0; });
        return static_cast<std::uint32_t>(cut - begin);
    }

    /// What is known of a child. That of a node waits on the stack: `waiting` is one past it, and
    /// then it. That of a triangle is written to `own`.
    const Cover& cover_of(const BinaryTree::Child& child, const Cover*& waiting, Cover& own) const
    {
        if (child.count > 1) return *--waiting;
        own.costs.fill(tree_.boxes[child.first].half_area());
        const auto [a, b, c] = mesh_.triangles()[to_index(tree_.order[child.first])];
        own.vertices.fill(Cover::no_vertex);
        std::uint32_t count = 0;
        own.vertices[count++] = a;
        if (b != a) own.vertices[count++] = b;
        if (c != a && c != b) own.vertices[count++] = c;
        own.vertex_count = count;
        return own;
    }

    /// \pre its children's covers are on the stack, the left one's on top; its own replaces them
    void choose_cover(const Run& at, std::vector<Cover>& pending)
    {
        BinaryNode& node = tree_.nodes[at.node];
        const auto [left, right] = tree_.children(at);
        std::array<Cover, 2> own;
        const Cover* waiting = pending.data() + pending.size();
        const Cover& left_cover = cover_of(left, waiting, own[0]);
        const Cover& right_cover = cover_of(right, waiting, own[1]);
        Cover cover;
        unite_vertices(left_cover, right_cover, cover);
        unite(tree_.box(left), tree_.box(right), node.box);
        // [k]: by k + 1 boxes of both children, of which shares[k] are the left one's.
        std::array<float, index_width> apart;
        apart.fill(float_infinity);
        std::array<std::uint32_t, index_width> shares;
        shares.fill(1);
        std::array<float, std::size_t{2} * index_width>
            shifted; // no box covers nothing: infinite before it
        shifted.fill(float_infinity);
        std::ranges::copy(right_cover.costs, shifted.begin() + index_width);
        // More boxes than triangles cover no better.
        const std::uint32_t most_share = std::min(index_width - 1, left.count);
        for (std::uint32_t share = 1; share <= most_share; ++share) {
            const float* const rest = shifted.data() + index_width - share;
            for (std::size_t k = 0; k < index_width; ++k) {
                const float sum = left_cover.costs[share - 1] + rest[k];
                const bool is_less = sum < apart[k];
                apart[k] = is_less ? sum : apart[k];
                shares[k] = is_less ? share : shares[k];
            }
        }
        const float area = node.box.half_area();
        const float as_node = area + apart[index_width - 1];
        const bool is_leaf =
            area <= as_node && at.count <= index_width && cover.vertex_count <= index_width;
        node.choices = is_leaf ? BinaryTree::leaf_choice : 0U;
        const float alone = is_leaf ? area : as_node;
        for (std::size_t k = 0; k < index_width; ++k)
            cover.costs[k] = apart[k] < alone ? apart[k] : alone;
        cover.costs[0] = alone;
        for (std::uint32_t most = 2; most <= index_width; ++most) {
            const std::size_t k = most - 1;
            node.choices |= shares[k] << BinaryTree::share_bit(most) |
                            static_cast<std::uint32_t>(!(apart[k] < alone))
                                << BinaryTree::single_bit(most);
        }
        pending.resize(static_cast<std::size_t>(waiting - pending.data()));
        pending.push_back(cover);
    }

    const TriangleMesh& mesh_;
    const OctreeFrame& root_;
    Threads threads_;
    Progress* progress_;
    GrowBuffer<KeyedIndex> keys_;
    BinaryTree tree_;
};

} // namespace

Result<BinaryTree> build_binary_tree(const TriangleMesh& mesh, const IndexFrame& frame,
                                     const OctreeFrame& root, Threads threads, Progress* progress)
{
    BinaryTreeBuilder builder(mesh, frame, root, threads, progress);
    if (!builder.sort_triangles() || !builder.make_nodes())
        return cancelled("building the mesh index");
    return builder.result();
}

} // namespace proxima
