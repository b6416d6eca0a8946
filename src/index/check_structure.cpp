#include "index/check_structure.h"

#include "base/atomic_bits.h"
#include "base/progress.h"
#include "base/text.h"
#include "index/check_blocks.h"
#include "index/check_work.h"
#include "index/index_parts.h"
#include "index/lists/check_lists.h"
#include "index/signs/check_signs.h"
#include "index/slabs/block_slab.h"
#include "proxima/topology.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace proxima {

namespace {

tl::unexpected<Error> bad_structure(std::string message, std::string where)
{
    return fail(ErrorCode::broken_invariant, std::move(message), std::move(where));
}

/// What a row says of its triangle; an empty text where it can be.
template <class Scalar>
const char* fault_of(const TriangleRow<Scalar>& row, const IndexParts& index)
{
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const std::uint32_t from = row.vertices[k];
        const std::uint32_t to = row.vertices[next];
        if (from >= index.vertex_count()) return "no such vertex";
        if (row.backward(k) != (from > to)) return "a side's direction is wrong";
        if ((row.edges[k] == to_index(no_edge)) != (from == to)) return "an edge of one vertex";
        if (from != to && row.edges[k] >= index.edge_count()) return "no such edge";
        for (const auto& line : row.coordinates) {
            if (from == to && line[k] != line[next]) return "a vertex at two positions";
        }
    }
    if (row.triangle_id() >= index.triangle_count()) return "no such triangle";
    return "";
}

/// Rows against the incidences of vertices and edges: each names the lowest triangle that has it.
class IncidenceChecker {
public:
    explicit IncidenceChecker(const IndexParts& index)
        : vertex_incidences_(index.vertex_incidences()), edge_incidences_(index.edge_incidences())
    {}

    /// Incidences that rows met.
    struct Met {
        std::size_t vertices = 0;
        std::size_t edges = 0;
    };

    /// An empty text where the row agrees. \pre its vertices and edges exist
    template <class Scalar>
    const char* fault_of(const TriangleRow<Scalar>& row, Met& met) const
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = row.vertices[k];
            const std::uint32_t corner = vertex_incidences_[vertex];
            if (incidence::triangle(corner) > row.triangle_id())
                return "a vertex's incidence is wrong";
            if (corner_of(row, vertex) == k && corner == word(row, k, false)) ++met.vertices;
            const std::uint32_t edge = row.edges[k];
            if (edge == to_index(no_edge)) continue;
            const std::uint32_t side = edge_incidences_[edge];
            if (incidence::triangle(side) > row.triangle_id())
                return "an edge's incidence is wrong";
            if (side_of(row, edge) == k && side == word(row, k, row.backward(k))) ++met.edges;
        }
        return "";
    }

    /// Thread safe.
    void add(const Met& met) noexcept
    {
        vertices_.fetch_add(met.vertices, std::memory_order_relaxed);
        edges_.fetch_add(met.edges, std::memory_order_relaxed);
    }

    /// Whether every incidence was met, once all was added.
    [[nodiscard]] bool all_met() const
    {
        const auto unused = std::ranges::count(vertex_incidences_, incidence::none);
        return vertices_ + static_cast<std::size_t>(unused) == vertex_incidences_.size() &&
               edges_ == edge_incidences_.size();
    }

private:
    template <class Scalar>
    static std::uint32_t word(const TriangleRow<Scalar>& row, std::size_t corner, bool backward)
    {
        return incidence::make(row.triangle_id(), static_cast<std::uint32_t>(corner), backward);
    }

    std::span<const std::uint32_t> vertex_incidences_;
    std::span<const std::uint32_t> edge_incidences_;
    std::atomic<std::size_t> vertices_ = 0;
    std::atomic<std::size_t> edges_ = 0;
};

template <class Scalar>
Status check_rows(std::span<const TriangleRow<Scalar>> rows, const IndexParts& index,
                  const CheckWork& work)
{
    AtomicBits seen(rows.size());
    IncidenceChecker incidences(index);
    const auto check_chunk = [&](std::size_t first, std::size_t end) -> Status {
        IncidenceChecker::Met met;
        for (std::size_t rank = first; rank < end; ++rank) {
            const TriangleRow<Scalar>& row = rows[rank];
            if (const char* const fault = fault_of(row, index); *fault != '\0')
                return bad_structure(fault, concat("row ", rank));
            if (index.id(static_cast<std::uint32_t>(rank)) != TriangleId{row.triangle_id()})
                return bad_structure("another triangle's id", concat("row ", rank));
            if (seen.set(row.triangle_id()))
                return bad_structure("a triangle twice", concat("row ", rank));
            if (const char* const fault = incidences.fault_of(row, met); *fault != '\0')
                return bad_structure(fault, concat("row ", rank));
        }
        incidences.add(met);
        return {};
    };
    if (Status status = work.run_chunks(rows.size(), sizeof(TriangleRow<Scalar>), check_chunk);
        !status)
        return status;
    if (!rows.empty() && !incidences.all_met())
        return bad_structure("incidences of no row", "vertices and edges");
    return {};
}

Status check_header(const IndexParts& index)
{
    if (!index.center().allFinite() || !is_power_of_two(index.scale()) ||
        !std::isfinite(index.unscale())) {
        return bad_structure("the frame is not finite", "frame");
    }
    const std::size_t count = index.triangle_count();
    const bool one_kind = index.float_rows().empty() != index.double_rows().empty();
    if (count == 0 || count > max_index_triangles || !one_kind ||
        index.float_rows().size() + index.double_rows().size() != count) {
        return bad_structure(concat("impossible number of triangles ", count), "rows");
    }
    if (!index.slabs().empty() && index.slabs().size() != index.blocks().size() + 7)
        return bad_structure("they are of other blocks", "slabs");
    return {};
}

Status check_all(const IndexParts& index, const CheckWork& work)
{
    if (Status status = check_header(index); !status) return status;
    if (Status status = check_rows(index.float_rows(), index, work); !status) return status;
    if (Status status = check_rows(index.double_rows(), index, work); !status) return status;
    if (Status status = check_blocks(index, work); !status) return status;
    if (index.lists() != nullptr) {
        if (Status status = check_lists(index, work); !status) return status;
    }
    return index.signs() != nullptr ? check_signs(index, work) : Status();
}

} // namespace

Status check_structure(const MeshIndex& index, const CheckStructureOptions& options)
{
    begin_stage(options.execution.progress, "checking the index", index.bytes());
    Status status = check_all(index.parts(), CheckWork(options.execution));
    if (status || status.error().code == ErrorCode::cancelled) return status;
    // Which of two claims to one thing comes second depends on threads; the message shall not.
    return check_all(index.parts(),
                     CheckWork({.threads = {1}, .progress = options.execution.progress}));
}

} // namespace proxima
