// Puts a Minkowski sum together from its facets, each a loop of corners.
#pragma once

#include "proxima/minkowski_sum.h"

#include <cstdint>
#include <vector>

namespace proxima {

/// Internal to the methods: the only one that fills a MinkowskiSum.
class PROXIMA_HIDDEN SumAssembler {
public:
    SumAssembler(const ConvexPolyhedron& a, const ConvexPolyhedron& b);

    [[nodiscard]] const ConvexPolyhedron& a() const noexcept { return parts_->a; }
    [[nodiscard]] const ConvexPolyhedron& b() const noexcept { return parts_->b; }

    /// Where the corners of the next facet go; add_facet() ends it.
    [[nodiscard]] std::vector<SumCorner>& corners() noexcept { return corners_; }
    /// Takes the corners since the last facet as the loop of this one.
    void add_facet(const SumFacet& facet);
    /// Forgets the corners since the last facet.
    void drop_corners();
    /// The facet of a sum that holds a line: it has no corners, but rests on one.
    void add_half_space(const SumFacet& facet, const SumCorner& support);

    /// The facets are all there. \pre one at least, and the loops close up to a surface
    [[nodiscard]] MinkowskiSum finish() &&;
    /// There are facets without corners, or none at all.
    [[nodiscard]] MinkowskiSum finish_with_line() &&;
    /// There are no facets: a point, a segment or a half-line.
    [[nodiscard]] MinkowskiSum finish_line(const std::vector<SumCorner>& ends) &&;

private:
    void number_corners();

    std::shared_ptr<MinkowskiSum::Parts> parts_;
    std::vector<SumCorner> corners_;
};

} // namespace proxima
