#include "haptics/proxy/contact_planes.h"

#include "base/check.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// sin^2 of the least angle between planes that are combined.
constexpr double least_sine_squared = 1e-22;
constexpr double least_determinant = 1e-16;

using Subset = std::array<std::uint8_t, 3>;

/// Computes the shift onto all planes of the subset. False where they do not meet.
bool meet(std::span<const ContactPlane> planes, const Subset& subset, std::size_t count,
          PlaneSolution& result) noexcept
{
    result.active = subset;
    result.count = count;
    const ContactPlane& a = planes[subset[0]];
    if (count == 1) {
        result.pressure[0] = -a.gap;
        result.shift = -a.gap * a.normal;
        return true;
    }
    const ContactPlane& b = planes[subset[1]];
    const Vec3 ab = a.normal.cross(b.normal);
    if (count == 2) {
        const double sine_squared = ab.squaredNorm();
        if (!(sine_squared > least_sine_squared)) return false;
        const double cosine = a.normal.dot(b.normal);
        result.pressure[0] = (cosine * b.gap - a.gap) / sine_squared;
        result.pressure[1] = (cosine * a.gap - b.gap) / sine_squared;
        // Along the dual basis of the normals, without differences of large multiples of them.
        result.shift = (-a.gap * b.normal.cross(ab) + b.gap * a.normal.cross(ab)) / sine_squared;
        return true;
    }
    const ContactPlane& c = planes[subset[2]];
    const double determinant = ab.dot(c.normal);
    if (!(std::abs(determinant) > least_determinant)) return false;
    const Vec3 bc = b.normal.cross(c.normal);
    const Vec3 ca = c.normal.cross(a.normal);
    result.shift = -(a.gap * bc + b.gap * ca + c.gap * ab) / determinant;
    result.pressure = {result.shift.dot(bc) / determinant, result.shift.dot(ca) / determinant,
                       result.shift.dot(ab) / determinant};
    return true;
}

double violation(const ContactPlane& plane, const Vec3& shift) noexcept
{
    return -(plane.gap + plane.normal.dot(shift));
}

/// Keeps the best of several solutions: the nearest that satisfies all members; where rounding
/// leaves none, the one with the smallest violation, marked infeasible.
class BestSubset {
public:
    BestSubset(std::span<const ContactPlane> planes, std::span<const std::uint8_t> members,
               double tolerance) noexcept
        : planes_(planes), members_(members), tolerance_(tolerance)
    {}

    void offer(const Subset& subset, std::size_t count) noexcept
    {
        PlaneSolution solution;
        if (!meet(planes_, subset, count, solution)) return;
        double worst = 0;
        for (const std::uint8_t member : members_)
            worst = std::max(worst, violation(planes_[member], solution.shift));
        solution.feasible = worst <= tolerance_;
        const double size = solution.shift.squaredNorm();
        const bool better = solution.feasible == best_.feasible
                                ? (solution.feasible ? size < size_ : worst < violation_)
                                : solution.feasible;
        if (!better) return;
        best_ = solution;
        size_ = size;
        violation_ = worst;
    }

    [[nodiscard]] const PlaneSolution& best() const noexcept { return best_; }

private:
    std::span<const ContactPlane> planes_;
    std::span<const std::uint8_t> members_;
    double tolerance_;
    PlaneSolution best_{.feasible = false};
    double size_ = std::numeric_limits<double>::infinity();
    double violation_ = std::numeric_limits<double>::infinity();
};

/// The best of all subsets of up to three planes that contain the last of `members`. Subsets of
/// fewer planes come first, for their feasible solutions are nearer.
PlaneSolution best_subset(std::span<const ContactPlane> planes,
                          std::span<const std::uint8_t> members, double tolerance) noexcept
{
    const std::uint8_t added = members.back();
    const auto others = members.first(members.size() - 1);
    BestSubset best(planes, members, tolerance);
    best.offer({added}, 1);
    if (best.best().feasible) return best.best();
    for (const std::uint8_t other : others) best.offer({added, other}, 2);
    if (best.best().feasible) return best.best();
    for (std::size_t i = 1; i < others.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) best.offer({added, others[k], others[i]}, 3);
    return best.best();
}

} // namespace

PlaneSolution nearest_allowed(std::span<const ContactPlane> planes, double tolerance) noexcept
{
    PROXIMA_CHECK_LE(planes.size(), max_contact_planes);
    PlaneSolution solution;
    if (planes.size() == 1) {
        const ContactPlane& plane = planes.front();
        if (!(-plane.gap > tolerance)) return solution;
        solution.count = 1;
        solution.pressure[0] = -plane.gap;
        solution.shift = -plane.gap * plane.normal;
        solution.feasible = violation(plane, solution.shift) <= tolerance;
        return solution;
    }
    // Every round raises |shift|, unless rounding prevents it.
    for (std::size_t round = 0; round < 2 * max_contact_planes; ++round) {
        std::size_t worst = planes.size();
        double worst_violation = tolerance;
        for (std::size_t i = 0; i < planes.size(); ++i) {
            const double by = violation(planes[i], solution.shift);
            if (by > worst_violation) {
                worst_violation = by;
                worst = i;
            }
        }
        if (worst == planes.size()) return solution;
        std::array<std::uint8_t, 4> members{};
        std::size_t count = 0;
        for (std::size_t i = 0; i < solution.count; ++i) {
            if (solution.active[i] != worst) members[count++] = solution.active[i];
        }
        members[count++] = static_cast<std::uint8_t>(worst);
        solution = best_subset(planes, std::span(members).first(count), tolerance);
        if (!solution.feasible) return solution;
    }
    solution.feasible = false;
    return solution;
}

} // namespace proxima
