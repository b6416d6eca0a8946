#include "index/check_edges.h"

#include "base/text.h"
#include "index/index_parts.h"

#include <algorithm>
#include <span>

namespace proxima {

namespace {

template <class Scalar>
Status compare(std::span<const TriangleRow<Scalar>> rows, const Topology& topology)
{
    for (const TriangleRow<Scalar>& row : rows) {
        const auto& edges = topology.edges(TriangleId{row.triangle_id()});
        if (!std::ranges::equal(row.edges, edges, {}, {},
                                [](EdgeId edge) { return to_index(edge); })) {
            return fail(ErrorCode::broken_invariant, "edges of another numbering",
                        concat("triangle ", row.triangle_id()));
        }
    }
    return {};
}

} // namespace

Status check_edges(const MeshIndex& index, const Topology& topology)
{
    if (index.edge_count() != topology.edge_count())
        return fail(ErrorCode::broken_invariant, "edges of another mesh", "edges");
    if (Status status = compare(index.parts().float_rows(), topology); !status) return status;
    return compare(index.parts().double_rows(), topology);
}

} // namespace proxima
