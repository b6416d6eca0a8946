#include "haptics/tool/least_constraint.h"

#include <cmath>
#include <limits>

namespace proxima {

namespace {

constexpr int max_steps = 64;
constexpr double infinite = std::numeric_limits<double>::infinity();

/// A vector in terms of active directions: their sum with these weights, and the rest, which is
/// orthogonal to all of them.
struct Decomposition {
    std::array<double, 6> weights = {};
    Vec6 rest;
};

/// The active set, with its directions made orthonormal: direction k is the sum of basis 0 to k with
/// the weights of column k.
class ActiveSet {
public:
    std::array<std::size_t, 6> ids = {};
    std::array<double, 6> pressure = {};
    std::size_t count = 0;

    /// \pre count < 6, and the rest is not zero
    void add(std::size_t id, double first_pressure, const Vec6& direction) noexcept
    {
        ids[count] = id;
        pressure[count] = first_pressure;
        directions_[count] = direction;
        orthonormalize(count);
        ++count;
    }
    void drop(std::size_t at) noexcept
    {
        for (std::size_t k = at; k + 1 < count; ++k) {
            ids[k] = ids[k + 1];
            pressure[k] = pressure[k + 1];
            directions_[k] = directions_[k + 1];
        }
        --count;
        for (std::size_t k = at; k < count; ++k) orthonormalize(k);
    }
    [[nodiscard]] Decomposition decompose(const Vec6& v) const noexcept
    {
        Decomposition result;
        result.rest = v;
        std::array<double, 6> along = {};
        // Twice: the first pass leaves what it rounded.
        for (int pass = 0; pass < 2; ++pass) {
            for (std::size_t k = 0; k < count; ++k) {
                const double part = basis_[k].dot(result.rest);
                along[k] += part;
                result.rest -= part * basis_[k];
            }
        }
        for (std::size_t k = count; k-- > 0;) {
            double sum = along[k];
            for (std::size_t later = k + 1; later < count; ++later)
                sum -= triangle_[later][k] * result.weights[later];
            result.weights[k] = sum / triangle_[k][k];
        }
        return result;
    }

private:
    void orthonormalize(std::size_t at) noexcept
    {
        Vec6 rest = directions_[at];
        triangle_[at] = {};
        for (int pass = 0; pass < 2; ++pass) {
            for (std::size_t k = 0; k < at; ++k) {
                const double part = basis_[k].dot(rest);
                triangle_[at][k] += part;
                rest -= part * basis_[k];
            }
        }
        const double length = rest.norm();
        triangle_[at][at] = length;
        basis_[at] = rest / length;
    }

    std::array<Vec6, 6> directions_;
    std::array<Vec6, 6> basis_;
    std::array<std::array<double, 6>, 6> triangle_ = {}; ///< by column
};

} // namespace

ConstrainedMotion least_constraint(const Vec6& wanted,
                                   std::span<const MotionConstraint> constraints,
                                   double tolerance) noexcept
{
    // Directions that differ by less from the span of the active ones count as dependent.
    constexpr double dependent = 1e-12;
    ConstrainedMotion result;
    result.motion = wanted;
    ActiveSet active;
    int steps = 0;
    while (true) {
        std::size_t worst = constraints.size();
        double least = -tolerance;
        for (std::size_t i = 0; i < constraints.size(); ++i) {
            const double slack = constraints[i].direction.dot(result.motion) - constraints[i].bound;
            if (slack < least) {
                least = slack;
                worst = i;
            }
        }
        if (worst == constraints.size()) break;
        const MotionConstraint& added = constraints[worst];
        double pressure = 0;
        bool is_added = false;
        while (!is_added) {
            if (++steps > max_steps) {
                result.solved = false;
                return result;
            }
            const Decomposition parts = active.decompose(added.direction);
            std::size_t blocking = active.count;
            double until_drop = infinite;
            for (std::size_t k = 0; k < active.count; ++k) {
                if (!(parts.weights[k] > 0)) continue;
                const double ratio = active.pressure[k] / parts.weights[k];
                if (ratio < until_drop) {
                    until_drop = ratio;
                    blocking = k;
                }
            }
            const double squared = parts.rest.squaredNorm();
            const bool moves =
                active.count < 6 && squared > dependent * added.direction.squaredNorm();
            const double slack = added.direction.dot(result.motion) - added.bound;
            const double until_met = moves ? std::max(-slack, 0.0) / squared : infinite;
            const double step = std::min(until_drop, until_met);
            if (!(step < infinite)) {
                result.solved = false;
                return result;
            }
            if (moves) result.motion += step * parts.rest;
            for (std::size_t k = 0; k < active.count; ++k)
                active.pressure[k] -= step * parts.weights[k];
            pressure += step;
            if (step == until_met) {
                active.add(worst, pressure, added.direction);
                is_added = true;
            } else {
                active.drop(blocking);
            }
        }
    }
    result.active = active.ids;
    result.pressure = active.pressure;
    result.active_count = active.count;
    return result;
}

} // namespace proxima
