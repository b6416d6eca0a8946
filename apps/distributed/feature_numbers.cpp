#include "distributed/feature_numbers.h"

#include "distributed/order_by_key.h"

#include <algorithm>
#include <span>

namespace proxima {

namespace {

/// An edge of a slice, as it is told to the rank that compares it with those of others.
struct SliceEdge {
    std::uint64_t low = 0; ///< vertices of the whole
    std::uint64_t high = 0;
    std::uint64_t first_side = 0; ///< 3 times the triangle of the whole, and the side
    std::int64_t excess = 0;      ///< triangles that run from low to high, less those that run back
};

struct SliceVertex {
    std::uint64_t id = 0;
    std::uint64_t triangle = 0;
};

/// The rank that compares a feature.
std::size_t rank_of(std::uint64_t low, std::uint64_t high, std::size_t ranks) noexcept
{
    std::uint64_t mixed = (low ^ high << 32U ^ high >> 32U) * 0x9E3779B97F4A7C15U;
    mixed = (mixed ^ mixed >> 32U) * 0xD6E8FEB86659FD93U;
    return (mixed ^ mixed >> 32U) % ranks;
}

/// Edges by their ends; equal ones keep their order.
std::vector<KeyedIndex> order_by_ends(const std::vector<SliceEdge>& edges)
{
    auto order = order_by_key(edges.size(), [&](std::uint32_t i) { return edges[i].low; });
    // Few edges share a lower end.
    std::uint64_t number = 0;
    for (std::size_t first = 0; first < order.size();) {
        std::size_t end = first + 1;
        while (end < order.size() && order[first].key == order[end].key) ++end;
        const auto run = std::span(order).subspan(first, end - first);
        std::ranges::stable_sort(run, {},
                                 [&](const KeyedIndex& at) { return edges[at.index].high; });
        // From here on the key tells edges apart.
        std::uint64_t high = edges[run.front().index].high;
        for (KeyedIndex& at : run) {
            if (edges[at.index].high != high) ++number;
            high = edges[at.index].high;
            at.key = number;
        }
        ++number;
        first = end;
    }
    return order;
}

class FeatureNumbering {
public:
    FeatureNumbering(const MeshSlice& slice, World& world)
        : slice_(slice), world_(world), ranks_(static_cast<std::size_t>(world.size()))
    {}

    Result<SliceFeatures> number()
    {
        Status status = name_vertices();
        if (status) status = compare_edges();
        if (status) status = number_edges_of_slice();
        if (!status) return tl::unexpected(status.error());
        features_.unbalanced_edges = world_.sum(unbalanced_edges_);
        return std::move(features_);
    }

private:
    /// The lowest triangle of every vertex.
    Status name_vertices()
    {
        std::vector<std::vector<SliceVertex>> outgoing(ranks_);
        std::vector<std::vector<std::uint32_t>> sent(ranks_);
        Status status = world_.agree_on([&]() -> Status {
            const auto triangles = slice_.mesh.triangles();
            features_.vertices.resize(slice_.vertices.size());
            for (std::size_t t = triangles.size(); t-- > 0;) {
                for (const std::uint32_t corner : triangles[t])
                    features_.vertices[corner].triangle = slice_.first_triangle + t;
            }
            for (std::uint32_t i = 0; i < slice_.vertices.size(); ++i) {
                WholeFeature& vertex = features_.vertices[i];
                vertex.id = slice_.vertices[i];
                const std::size_t r = rank_of(vertex.id, 0, ranks_);
                outgoing[r].push_back({vertex.id, vertex.triangle});
                sent[r].push_back(i);
            }
            return {};
        });
        if (!status) return status;
        const auto received = world_.exchange(std::move(outgoing));
        if (!received) return tl::unexpected(received.error());
        std::vector<std::uint64_t> lowest;
        status = world_.agree_on([&]() -> Status {
            lowest.resize(received->items.size());
            // Slices ascend, so that the lowest triangle of a vertex comes first.
            const auto order =
                order_by_key(lowest.size(), [&](std::uint32_t i) { return received->items[i].id; });
            each_group(order, [&](std::span<const KeyedIndex> group) {
                for (const KeyedIndex& at : group)
                    lowest[at.index] = received->items[group.front().index].triangle;
            });
            return {};
        });
        if (!status) return status;
        const auto answers = world_.reply(*received, std::move(lowest));
        if (!answers) return tl::unexpected(answers.error());
        for (std::size_t r = 0; r < ranks_; ++r) {
            for (std::size_t k = 0; k < sent[r].size(); ++k)
                features_.vertices[sent[r][k]].triangle = answers->items[answers->first[r] + k];
        }
        return {};
    }

    /// Finds which slice has the first side of every edge.
    Status compare_edges()
    {
        std::vector<std::vector<SliceEdge>> outgoing(ranks_);
        Status status = world_.agree_on([&] { return collect_edges(outgoing); });
        if (!status) return status;
        auto received = world_.exchange(std::move(outgoing));
        if (!received) return tl::unexpected(received.error());
        edges_ = std::move(*received);
        std::vector<std::uint64_t> first_sides;
        status = world_.agree_on([&]() -> Status {
            // Slices ascend, and so the first sides of an edge.
            order_ = order_by_ends(edges_.items);
            first_sides.resize(edges_.items.size());
            each_group(order_, [&](std::span<const KeyedIndex> group) {
                std::int64_t excess = 0;
                for (const KeyedIndex& at : group) {
                    first_sides[at.index] = edges_.items[group.front().index].first_side;
                    excess += edges_.items[at.index].excess;
                }
                if (excess != 0) ++unbalanced_edges_;
            });
            return {};
        });
        if (!status) return status;
        const auto answers = world_.reply(edges_, std::move(first_sides));
        if (!answers) return tl::unexpected(answers.error());
        for (std::size_t r = 0; r < ranks_; ++r) {
            for (std::size_t k = 0; k < sent_[r].size(); ++k)
                first_sides_[sent_[r][k]] = answers->items[answers->first[r] + k];
        }
        return {};
    }

    Status collect_edges(std::vector<std::vector<SliceEdge>>& outgoing)
    {
        auto numbers = number_edges(slice_.mesh, nullptr);
        if (!numbers) return tl::unexpected(numbers.error());
        features_.triangle_edges = std::move(numbers->triangle_edges);
        std::vector<SliceEdge> edges(numbers->first_sides.size());
        first_sides_.resize(edges.size());
        for (std::size_t i = 0; i < edges.size(); ++i)
            edges[i].first_side = 3 * slice_.first_triangle + numbers->first_sides[i];
        const auto triangles = slice_.mesh.triangles();
        for (std::size_t t = 0; t < triangles.size(); ++t) {
            const TriangleCorners& corners = triangles[t];
            for (std::size_t k = 0; k < 3; ++k) {
                const EdgeId id = features_.triangle_edges[t][k];
                if (id == no_edge) continue;
                const std::uint32_t from = corners[k];
                const std::uint32_t to = corners[(k + 1) % 3];
                SliceEdge& edge = edges[to_index(id)];
                edge.low = slice_.vertices[std::min(from, to)];
                edge.high = slice_.vertices[std::max(from, to)];
                // A triangle that repeats a vertex runs along its edge there and back.
                edge.excess += from < to ? 1 : -1;
            }
        }
        sent_.resize(ranks_);
        for (std::uint32_t i = 0; i < edges.size(); ++i) {
            const std::size_t r = rank_of(edges[i].low, edges[i].high, ranks_);
            outgoing[r].push_back(edges[i]);
            sent_[r].push_back(i);
            own_sides_.push_back(edges[i].first_side);
        }
        return {};
    }

    /// Numbers the edges that this slice has first, and asks for the others' numbers.
    Status number_edges_of_slice()
    {
        std::uint64_t added = 0;
        Status status = world_.agree_on([&]() -> Status {
            features_.edges.resize(own_sides_.size());
            for (std::size_t i = 0; i < own_sides_.size(); ++i) {
                features_.edges[i].triangle = first_sides_[i] / 3;
                if (is_first(i)) features_.edges[i].id = added++;
            }
            return {};
        });
        if (!status) return status;
        const std::uint64_t before = world_.sum_before(added);
        std::vector<std::vector<std::uint64_t>> outgoing(ranks_);
        status = world_.agree_on([&]() -> Status {
            for (std::size_t r = 0; r < ranks_; ++r) {
                for (const std::uint32_t i : sent_[r]) {
                    if (is_first(i)) features_.edges[i].id += before;
                    outgoing[r].push_back(features_.edges[i].id); // 0 where it is not known
                }
            }
            return {};
        });
        if (!status) return status;
        auto numbers = world_.exchange(std::move(outgoing));
        if (!numbers) return tl::unexpected(numbers.error());
        each_group(order_, [&](std::span<const KeyedIndex> group) {
            for (const KeyedIndex& at : group)
                numbers->items[at.index] = numbers->items[group.front().index];
        });
        const auto answers = world_.reply(edges_, std::move(numbers->items));
        if (!answers) return tl::unexpected(answers.error());
        for (std::size_t r = 0; r < ranks_; ++r) {
            for (std::size_t k = 0; k < sent_[r].size(); ++k)
                features_.edges[sent_[r][k]].id = answers->items[answers->first[r] + k];
        }
        return {};
    }

    [[nodiscard]] bool is_first(std::size_t edge) const noexcept
    {
        return own_sides_[edge] == first_sides_[edge];
    }

    const MeshSlice& slice_;
    World& world_;
    std::size_t ranks_;
    SliceFeatures features_;
    std::vector<std::uint64_t> own_sides_;         ///< by edge of the slice
    std::vector<std::uint64_t> first_sides_;       ///< by edge of the slice, in the whole
    std::vector<std::vector<std::uint32_t>> sent_; ///< by rank, edges of the slice
    Received<SliceEdge> edges_;                    ///< that this rank compares
    std::vector<KeyedIndex> order_;                ///< of these: the same key for the same edge
    std::uint64_t unbalanced_edges_ = 0;           ///< of these
};

} // namespace

Result<SliceFeatures> number_features(const MeshSlice& slice, World& world)
{
    return FeatureNumbering(slice, world).number();
}

} // namespace proxima
