// On which side of an open mesh balls are that its surface does not enter.
//
// Away from the surface the winding number changes with its border alone, as the potential of a current
// in it: by at most L / (4 pi d^2) per length, for a piece of border of length L that is nowhere nearer
// than d (Biot and Savart's law). So a ball of radius r is on one side where the number at its middle
// differs from 1/2 by more than r times the sum of these.
#pragma once

#include "index/index_parts.h"
#include "query/field/search_grid.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace proxima {

/// Refers to the index.
class PROXIMA_HIDDEN OpenSides {
public:
    /// O(triangles). \pre the index has signs
    explicit OpenSides(const IndexParts& index);

    /// Bytes that it takes while it is made.
    [[nodiscard]] static std::uint64_t bytes(const IndexParts& index) noexcept;

    /// Whether all of a ball is inside: then is_inside_by_winding says the same at all of its points.
    /// Nothing in doubt. No allocation, thread safe.
    [[nodiscard]] std::optional<bool> side_of(const ClearBall& ball) const noexcept;

private:
    /// How fast the winding number changes in a ball at most, in the unit of the clusters; infinite
    /// where that is more than `enough`.
    [[nodiscard]] double slope_in(const ClearBall& ball, double enough) const noexcept;

    const IndexParts& index_;
    /// By cluster, of its triangles' sides that are the border: edges with more triangles one way than
    /// the other, as often as there are more. In the unit of clusters.
    std::vector<double> borders_;
};

} // namespace proxima
