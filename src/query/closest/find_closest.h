// The search behind closest_feature(), for searches that go on with what it finds, and for counting
// its work.
#pragma once

#include "index/index_parts.h"
#include "proxima/closest_feature.h"

#include <cstdint>
#include <optional>
#include <span>

namespace proxima {

struct RowDistance;

/// The closest feature of the index's rows by the order of answers, in the index's units. `known`,
/// in the mesh's unit: nothing farther is wanted, but may be found.
[[nodiscard]] RowDistance find_closest(const IndexParts& index, const Vec3& p,
                                       double known) noexcept;

/// Like closest_features() on this thread, within a stage that somebody has entered: a step for each
/// point. Answers are worthless where the progress object asks to stop. \pre points are finite, and
/// as many as answers
void find_closest_features(const MeshIndex& index, std::span<const Vec3> points,
                           std::span<ClosestFeature> answers, BatchOrder order, Progress* progress);

/// Work counters of one query, for worst-case tests and tuning.
struct QuerySteps {
    std::uint32_t steps = 0;    ///< words of the lists' table and nodes read
    std::uint32_t blocks = 0;   ///< of a leaf's list, scanned
    std::uint32_t rechecks = 0; ///< triangles of lists looked at in doubles
    std::uint32_t searches = 0; ///< of the tree: without lists, outside of their root, and in
                                ///< leaves without one
};

/// Like closest_feature(), and counts the work done: at most worst_case_steps words and
/// worst_case_blocks blocks of the lists' statistics() in leaves that have a list.
[[nodiscard]] std::optional<ClosestFeature> closest_feature(const MeshIndex& index, const Vec3& p,
                                                            const ClosestFeatureOptions& options,
                                                            QuerySteps& steps) noexcept;

} // namespace proxima
