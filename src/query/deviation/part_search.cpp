#include "query/deviation/part_search.h"

#include <algorithm>
#include <vector>

namespace proxima {

namespace {

struct BoundedPiece {
    NearPiece piece;
    double upper = 0;
};

} // namespace

void PartSearch::search_triangle(const MeasuredVertices& vertices, std::uint32_t row, double upper,
                                 PartOutcome& outcome)
{
    if (!(upper > limit(outcome))) {
        outcome.settled.add(upper, 0);
        return;
    }
    BoundedPart whole = bounded_triangle(pair_, vertices, row);
    const auto& [p, q, r] = whole.part.corners;
    const Vec3 centroid = (p + q + r) / 3;
    const NearestRow nearest = pair_.nearest(centroid, whole.part.reach(centroid));
    outcome.farthest.offer(nearest, centroid, row, 1);
    whole.upper = std::min({upper, whole.upper, upper_by(pair_, whole.part, nearest.row)});
    search_part(whole, outcome);
}

void PartSearch::cover(BoundedPart& part, PartOutcome& outcome)
{
    const CoverBound bound = cover_.bound(part.part, limit(outcome), part.upper);
    if (bound.cuts > most_cuts) return;
    // Cuts are rounded: what is gained must be more than that.
    if (!(bound.upper + pair_.rounding(bound.cuts) < part.upper + pair_.rounding(part.part.cuts)))
        return;
    part.upper = bound.upper;
    outcome.settled.allow(bound.cuts);
    if (!(bound.upper > greatest(outcome))) return;
    outcome.farthest.offer(pair_.nearest(bound.point, bound.upper), bound.point, part.row_a,
                           bound.cuts);
}

void PartSearch::search_part(BoundedPart start, PartOutcome& outcome)
{
    const auto most = [&] { return limit(outcome); };
    if (start.part.cuts < most_cuts && start.upper > most()) cover(start, outcome);
    if (start.part.cuts >= most_cuts || !(start.upper > most())) {
        outcome.settled.add(start.upper, start.part.cuts);
        return;
    }
    NearPiece whole;
    if (!pieces_.start(start.part, whole)) {
        halve(start, outcome);
        return;
    }
    std::vector<BoundedPiece> heap = {{whole, std::min(pieces_.upper(whole), start.upper)}};
    for (std::uint64_t splits = 0; !heap.empty(); ++splits) {
        if (!(heap.front().upper > most()) || splits == most_splits_ || pieces_.is_full()) break;
        std::ranges::pop_heap(heap, HasLowerBound());
        const BoundedPiece highest = heap.back();
        heap.pop_back();
        if (highest.piece.cuts >= most_cuts) {
            outcome.settled.add(highest.upper, highest.piece.cuts);
            continue;
        }
        const auto [parts, corner] = pieces_.split(highest.piece);
        ++outcome.splits;
        offer_corner(pieces_.part(parts[0]), corner, start.row_a, outcome);
        for (const NearPiece& piece : parts) {
            heap.push_back({piece, std::min(pieces_.upper(piece), highest.upper)});
            std::ranges::push_heap(heap, HasLowerBound());
        }
    }
    outcome.left.reserve(heap.size());
    for (const auto& [piece, upper] : heap) {
        if (upper > most()) {
            outcome.left.push_back({pieces_.part(piece), start.row_a, upper});
        } else {
            outcome.settled.add(upper, piece.cuts);
        }
    }
}

/// The corner that a cut made, where it may be farther than all before.
void PartSearch::offer_corner(const MeasuredPart& part, std::size_t corner, std::uint32_t row_a,
                              PartOutcome& outcome) const
{
    const double distance = part.nearest[corner].distance;
    if (!(distance > greatest(outcome))) return;
    const Vec3& point = part.corners[corner];
    outcome.farthest.offer(pair_.nearest(point, distance), point, row_a, part.cuts);
}

void PartSearch::halve(const BoundedPart& start, PartOutcome& outcome) const
{
    const MeasuredPart::Halves halves = start.part.halves(pair_);
    ++outcome.splits;
    outcome.farthest.offer(halves.nearest, halves.corner, start.row_a, start.part.cuts + 1);
    for (const MeasuredPart& half : halves.parts) {
        BoundedPart some = bounded_part(pair_, half, start.row_a);
        some.upper = std::min(some.upper, start.upper);
        outcome.left.push_back(some);
    }
}

} // namespace proxima
