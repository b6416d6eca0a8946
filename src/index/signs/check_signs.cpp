#include "index/signs/check_signs.h"

#include "base/atomic_bits.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/signs/sign_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace proxima {

namespace {

tl::unexpected<Error> bad_signs(const char* fault, std::string where)
{
    return fail(ErrorCode::broken_invariant, fault, std::move(where));
}

class SignChecker {
public:
    SignChecker(const IndexParts& index, const CheckWork& work)
        : index_(index), signs_(index.signs()->arrays()), work_(work)
    {}

    [[nodiscard]] Status run() const
    {
        if (Status status = check_sizes(); !status) return status;
        if (Status status = check_rows(); !status) return status;
        if (Status status = check_sides(); !status) return status;
        if (Status status = check_edges(); !status) return status;
        return check_clusters();
    }

private:
    [[nodiscard]] Status check_sizes() const
    {
        const std::size_t triangles = index_.triangle_count();
        if (signs_.rows.size() != triangles || signs_.winding.order.size() != triangles)
            return bad_signs("signs of another number of triangles", "signs");
        const std::array<std::size_t, 4> found = {signs_.sides.size(), signs_.vertex_sides.size(),
                                                  signs_.vertices.size(), signs_.edges.size()};
        const std::array<std::size_t, 4> all = {triangles, index_.vertex_count(),
                                                index_.vertex_count(), index_.edge_count()};
        if (found != all && found != std::array<std::size_t, 4>{})
            return bad_signs("signs of another number of vertices or edges", "signs");
        int exponent = 0;
        const double unit = signs_.winding.unit;
        if (!std::isfinite(unit) || std::frexp(unit, &exponent) != 0.5)
            return bad_signs("the unit is no power of two", "signs");
        return {};
    }

    /// Calls fault_at(i) for all items, in parallel; it returns an empty text where all is well.
    template <class FaultAt>
    [[nodiscard]] Status check_items(std::size_t count, std::size_t item_bytes, const char* item,
                                     const FaultAt& fault_at) const
    {
        return work_.run_chunks(
            count, item_bytes, [&](std::size_t first, std::size_t end) -> Status {
                for (std::size_t i = first; i < end; ++i) {
                    if (const char* const fault = fault_at(i); *fault != '\0')
                        return bad_signs(fault, concat("signs of ", item, " ", i));
                }
                return {};
            });
    }

    [[nodiscard]] Status check_rows() const
    {
        return check_items(
            signs_.rows.size(), sizeof(std::uint32_t), "triangle", [&](std::size_t id) {
                const std::uint32_t row = signs_.rows[id];
                const bool is_its = row < index_.triangle_count() && to_index(index_.id(row)) == id;
                return is_its ? "" : "another triangle's row";
            });
    }

    [[nodiscard]] Status check_sides() const
    {
        const auto check = [&](std::span<const SurfaceSides> sides, const char* item) {
            return check_items(sides.size(), 1, item, [&](std::size_t i) {
                return sides[i] <= SurfaceSides::outside_both ? "" : "no such sides";
            });
        };
        if (Status status = check(signs_.sides, "row"); !status) return status;
        return check(signs_.vertex_sides, "vertex");
    }

    [[nodiscard]] bool has_edge(std::uint32_t row, std::size_t edge) const
    {
        if (row >= index_.triangle_count()) return false;
        const auto is_in = [&](const auto& rows) {
            return std::ranges::find(rows[row].edges, edge) != std::end(rows[row].edges);
        };
        return index_.double_rows().empty() ? is_in(index_.float_rows())
                                            : is_in(index_.double_rows());
    }

    /// One after the other, for lists follow each other.
    [[nodiscard]] Status check_edges() const
    {
        std::size_t used = 0;
        StageSteps steps = work_.steps();
        for (std::size_t edge = 0; edge < signs_.edges.size(); ++edge) {
            if (!steps.done(sizeof(std::uint32_t))) return cancelled("checking the index");
            const auto bad = [&](const char* fault) {
                return bad_signs(fault, concat("signs of edge ", edge));
            };
            const std::uint32_t word = signs_.edges[edge];
            if ((word & edge_list_bit) == 0) {
                if (!has_edge(word, edge)) return bad("a triangle without the edge");
                continue;
            }
            const std::size_t left = signs_.edge_lists.size() - used;
            if ((word & ~edge_list_bit) != used || left == 0 || signs_.edge_lists[used] > left - 1)
                return bad("no such list");
            const std::size_t count = signs_.edge_lists[used];
            for (const std::uint32_t row : signs_.edge_lists.subspan(used + 1, count)) {
                if (!has_edge(row, edge)) return bad("a triangle without the edge");
            }
            used += 1 + count;
        }
        if (used != signs_.edge_lists.size()) return bad_signs("lists of no edge", "signs");
        return {};
    }

    /// By these every cluster's triangles are those of its two children, down to leaves, which part
    /// those of the first cluster.
    [[nodiscard]] const char* fault_of_cluster(std::size_t i) const
    {
        const auto& clusters = signs_.winding.clusters;
        const WindingCluster& cluster = clusters[i];
        if (i == 0 && (cluster.first != 0 || cluster.count != signs_.winding.order.size() ||
                       cluster.next != clusters.size()))
            return "not all triangles";
        if (cluster.next <= i || cluster.next > clusters.size() || cluster.count == 0)
            return "clusters that form no tree";
        if (signs_.winding.is_leaf(i)) return "";
        const std::size_t left = i + 1;
        const std::size_t right = clusters[left].next;
        if (right <= left || right >= cluster.next || clusters[right].next != cluster.next ||
            clusters[left].first != cluster.first ||
            clusters[right].first != std::uint64_t{cluster.first} + clusters[left].count ||
            cluster.count != std::uint64_t{clusters[left].count} + clusters[right].count)
            return "clusters that form no tree";
        return "";
    }

    [[nodiscard]] Status check_clusters() const
    {
        if (signs_.winding.clusters.empty()) return bad_signs("no clusters", "signs");
        Status status = check_items(signs_.winding.clusters.size(), sizeof(WindingCluster),
                                    "cluster", [&](std::size_t i) { return fault_of_cluster(i); });
        if (!status) return status;
        AtomicBits seen(signs_.winding.order.size());
        return check_items(signs_.winding.order.size(), sizeof(std::uint32_t), "position",
                           [&](std::size_t i) {
                               const std::uint32_t row = signs_.winding.order[i];
                               if (row >= index_.triangle_count()) return "no such row";
                               return seen.set(row) ? "a row twice" : "";
                           });
    }

    const IndexParts& index_;
    const SignArrays& signs_;
    const CheckWork& work_;
};

} // namespace

Status check_signs(const IndexParts& index, const CheckWork& work)
{
    return SignChecker(index, work).run();
}

} // namespace proxima
