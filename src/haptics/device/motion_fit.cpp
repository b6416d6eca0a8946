#include "haptics/device/motion_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace proxima {

namespace {

/// Per mass: a = 1/m, damping, friction, stiffness, weight. Positions depend on these almost
/// linearly.
constexpr int parameter_count = 5;

/// A friction below this, N, is rounding.
constexpr double least_friction = 1e-6;

/// Parts of the sum of squares: fits of delays that come into question go on as long as a round takes
/// more than the second, others the first.
constexpr double roughly = 1e-4;
constexpr double exactly = 1e-7;

using Parameters = Eigen::Matrix<double, parameter_count, 1>;
using Normal = Eigen::Matrix<double, parameter_count, parameter_count>;

struct Motion {
    double x = 0;
    double v = 0;
};

/// Motion under a constant acceleration against damping for some time: what is left of a velocity,
/// and the time over which it, and an acceleration, act.
struct Decay {
    double seconds = 0;
    double left = 1;
    double first = 0;  ///< s: the integral of what is left
    double second = 0; ///< s^2: the integral of `first`

    Decay() = default;
    Decay(double damping, double time) noexcept : seconds(time)
    {
        const double decay = damping * time;
        left = std::exp(-decay);
        // Series for slow decay, which the formulas would lose to rounding.
        const bool slow = decay < 1e-3;
        first = slow ? time * (1 - decay / 2 + decay * decay / 6) : (1 - left) / damping;
        second =
            slow ? time * time * (0.5 - decay / 6 + decay * decay / 24) : (time - first) / damping;
    }
};

/// The motion over a tick under a constant acceleration `u` against damping and friction, exactly.
void advance(Motion& motion, double u, double damping, double friction, const Decay& tick) noexcept
{
    Decay part = tick;
    double seconds = tick.seconds;
    // It may stop and go on in the other direction, but not twice.
    for (int piece = 0; piece < 2; ++piece) {
        const bool rests = motion.v == 0;
        if (rests && std::abs(u) <= friction) return;
        const double direction = std::copysign(1.0, rests ? u : motion.v);
        const double driven = u - friction * direction;
        const double end = motion.v * part.left + driven * part.first;
        if (rests || end * direction > 0) {
            motion.x += motion.v * part.first + driven * part.second;
            motion.v = end;
            return;
        }
        const double until = damping * seconds > 1e-6
                                 ? std::log1p(-damping * motion.v / driven) / damping
                                 : -motion.v / driven;
        const Decay before(damping, std::clamp(until, 0.0, seconds));
        motion.x += motion.v * before.first + driven * before.second;
        motion.v = 0;
        seconds -= before.seconds;
        part = Decay(damping, seconds);
    }
}

/// The slope of the positions before the force, m/s.
double velocity_before(const Push& push)
{
    if (push.lead < 3) return 0;
    double mean_t = 0;
    double mean_x = 0;
    const auto n = static_cast<double>(push.lead);
    for (std::size_t i = 0; i < push.lead; ++i) {
        mean_t += push.samples[i].seconds / n;
        mean_x += push.samples[i].position / n;
    }
    double product = 0;
    double squares = 0;
    for (std::size_t i = 0; i < push.lead; ++i) {
        const double t = push.samples[i].seconds - mean_t;
        product += t * (push.samples[i].position - mean_x);
        squares += t * t;
    }
    return squares > 0 ? product / squares : 0;
}

/// The samples until a little after the tip has stopped: all later ones have the same rounding error.
std::size_t end_of_motion(const Push& push, double resolution)
{
    constexpr std::size_t at_rest = 20;
    std::size_t end = push.samples.size();
    while (end > push.lead &&
           std::abs(push.samples[end - 1].position - push.samples.back().position) < resolution / 2)
        --end;
    return std::min(end + at_rest, push.samples.size());
}

class Fit {
public:
    Fit(std::span<const Push> pushes, double resolution) : pushes_(pushes)
    {
        std::size_t count = 0;
        for (const Push& push : pushes) {
            starts_.push_back(velocity_before(push));
            ends_.push_back(end_of_motion(push, resolution));
            count += push.samples.size();
        }
        residuals_.reserve(count);
        for (auto& column : columns_) column.reserve(count);
    }

    /// Measured less modelled positions of fresh samples; each push's mean is taken off, since
    /// where exactly it began is not known.
    void residuals_of(const Parameters& p, int delay, std::vector<double>& out) const
    {
        out.clear();
        for (std::size_t k = 0; k < pushes_.size(); ++k) {
            const Push& push = pushes_[k];
            const std::size_t begin = out.size();
            Motion motion{0, starts_[k]};
            double sum = 0;
            Decay tick;
            for (std::size_t i = push.lead; i < ends_[k]; ++i) {
                const PushSample& now = push.samples[i];
                if (now.fresh) {
                    out.push_back(now.position - motion.x);
                    sum += out.back();
                }
                if (i + 1 == ends_[k]) break;
                const double seconds = push.samples[i + 1].seconds - now.seconds;
                const auto late = static_cast<std::size_t>(delay);
                const double force = i >= late ? push.samples[i - late].force : 0;
                // The spring at the middle of the tick: exact to second order.
                const double middle = motion.x + motion.v * seconds / 2;
                if (seconds != tick.seconds) tick = Decay(p[1], seconds);
                advance(motion, p[0] * force + p[4] - p[3] * middle, p[1], p[2], tick);
            }
            const double mean =
                sum / static_cast<double>(std::max<std::size_t>(out.size() - begin, 1));
            for (std::size_t i = begin; i < out.size(); ++i) out[i] -= mean;
        }
    }

    /// Improves the parameters for a delay, until a round takes no more than a part `least_gain` from
    /// the sum of squares, which it returns.
    double improve(Parameters& p, int delay, int rounds, double least_gain)
    {
        double lambda = 1e-3;
        residuals_of(p, delay, residuals_);
        double best = sum_of_squares(residuals_);
        for (int round = 0; round < rounds; ++round) {
            differentiate(p, delay);
            keep_at_bounds(p);
            bool better = false;
            for (int attempt = 0; attempt < 6 && !better; ++attempt) {
                Normal damped = normal_;
                damped.diagonal() *= 1 + lambda;
                damped.diagonal().array() += 1e-30;
                Parameters next = p + damped.ldlt().solve(gradient_);
                if (!next.allFinite()) break;
                next[0] = std::max(next[0], 0.0);
                for (int i = 1; i <= 3; ++i) next[i] = std::max(next[i], 0.0);
                residuals_of(next, delay, trial_);
                const double sum = sum_of_squares(trial_);
                if (sum < best) {
                    better = best - sum > least_gain * best;
                    best = sum;
                    p = next;
                    std::swap(residuals_, trial_);
                    lambda = std::max(lambda / 10, 1e-9);
                    if (!better) return best;
                } else {
                    lambda *= 10;
                }
            }
            if (!better) break;
        }
        return best;
    }

    /// Standard errors about a solution, as if `count` residuals of that size were independent.
    Parameters errors(const Parameters& p, int delay, double variance)
    {
        residuals_of(p, delay, residuals_);
        differentiate(p, delay);
        const Normal inverse = (normal_ + Normal(normal_.diagonal().asDiagonal()) * 1e-12)
                                   .ldlt()
                                   .solve(Normal::Identity());
        return (inverse.diagonal().cwiseAbs() * variance).cwiseSqrt();
    }

    [[nodiscard]] std::size_t count() const noexcept { return residuals_.size(); }

private:
    static double sum_of_squares(const std::vector<double>& values)
    {
        double sum = 0;
        for (const double value : values) sum += value * value;
        return sum;
    }

    /// Numbers that are 0, and that the gradient wants below, stay.
    void keep_at_bounds(const Parameters& p)
    {
        for (int i = 1; i <= 3; ++i) {
            if (p[i] > 0 || gradient_[i] > 0) continue;
            normal_.row(i).setZero();
            normal_.col(i).setZero();
            normal_(i, i) = 1;
            gradient_[i] = 0;
        }
    }

    /// Fills normal_ and gradient_ about parameters, whose residuals are in residuals_.
    void differentiate(const Parameters& p, int delay)
    {
        const Parameters least = (Parameters() << 1e-3, 1e-3, 1e-4, 1e-1, 1e-4).finished();
        for (int i = 0; i < parameter_count; ++i) {
            Parameters moved = p;
            const double step = std::max(1e-4 * std::abs(p[i]), least[i]);
            moved[i] += step;
            std::vector<double>& column = columns_[static_cast<std::size_t>(i)];
            residuals_of(moved, delay, column);
            for (std::size_t j = 0; j < column.size(); ++j)
                column[j] = (residuals_[j] - column[j]) / step;
        }
        for (int i = 0; i < parameter_count; ++i) {
            const std::vector<double>& a = columns_[static_cast<std::size_t>(i)];
            for (int k = 0; k <= i; ++k) {
                const std::vector<double>& b = columns_[static_cast<std::size_t>(k)];
                double sum = 0;
                for (std::size_t j = 0; j < a.size(); ++j) sum += a[j] * b[j];
                normal_(i, k) = normal_(k, i) = sum;
            }
            double sum = 0;
            for (std::size_t j = 0; j < a.size(); ++j) sum += a[j] * residuals_[j];
            gradient_[i] = sum;
        }
    }

    std::span<const Push> pushes_;
    std::vector<double> starts_;    ///< m/s, of each push
    std::vector<std::size_t> ends_; ///< of its samples
    std::vector<double> residuals_;
    std::vector<double> trial_;
    std::array<std::vector<double>, parameter_count> columns_;
    Normal normal_ = Normal::Zero();
    Parameters gradient_ = Parameters::Zero();
};

/// The largest distance that a push moved the device.
double travel_of(std::span<const Push> pushes)
{
    double travel = 0;
    for (const Push& push : pushes) {
        double least = std::numeric_limits<double>::infinity();
        double most = -least;
        for (const PushSample& sample : push.samples) {
            least = std::min(least, sample.position);
            most = std::max(most, sample.position);
        }
        travel = std::max(travel, most - least);
    }
    return travel;
}

} // namespace

MotionFit fit_motion(std::span<const Push> pushes, const MotionFitOptions& options)
{
    MotionFit result;
    if (pushes.empty()) return result;
    result.travel = travel_of(pushes);
    if (!(result.travel > 8 * options.resolution) || !(result.travel > 0)) return result;

    Fit fit(pushes, options.resolution);
    // From masses that devices have, the nearest at no delay.
    Parameters start = Parameters::Zero();
    double least = std::numeric_limits<double>::infinity();
    for (const double mass : {0.02, 0.05, 0.1, 0.2, 0.5, 1.0}) {
        Parameters p = Parameters::Zero();
        p[0] = 1 / mass;
        p[1] = 2;
        p[2] = 0.5;
        const double sum = fit.improve(p, 2, 6, roughly);
        if (sum < least) {
            least = sum;
            start = p;
        }
    }
    const auto count_of_delays = static_cast<std::size_t>(options.most_delay) + 1;
    std::vector<double> sums(count_of_delays, std::numeric_limits<double>::infinity());
    std::vector<Parameters> solutions(count_of_delays, start);
    // From the start, and from the solutions of the delays beside it, so that no delay is judged by a
    // local minimum.
    const auto try_from = [&](std::size_t delay, Parameters p) {
        const double sum = fit.improve(p, static_cast<int>(delay), 12, roughly);
        if (!(sum < sums[delay])) return;
        sums[delay] = sum;
        solutions[delay] = p;
    };
    for (std::size_t delay = 0; delay < count_of_delays; ++delay) {
        try_from(delay, start);
        if (delay > 0) try_from(delay, solutions[delay - 1]);
    }
    for (std::size_t delay = count_of_delays - 1; delay-- > 0;)
        try_from(delay, solutions[delay + 1]);

    // Errors of neighbouring samples of a slow motion through encoder steps are alike: as many are
    // independent as the motion crosses steps. A tenth of the samples is less than that.
    const auto count = static_cast<double>(fit.count());
    const double independent = std::max(count / 10, 2.0 * parameter_count);
    const double rounding = options.resolution * options.resolution / 12;
    const auto variance_of = [&](double sum) { return std::max(sum / count, rounding); };
    // Twice the logarithm of the likelihood's ratio; what excludes a delay at a per mille.
    const auto excess = [&](std::size_t delay, double least_sum) {
        return independent * (sums[delay] - least_sum) / (count * variance_of(least_sum));
    };
    constexpr double excludes = 10.8;
    const double rough_sum = std::ranges::min(sums);
    for (std::size_t delay = 0; delay < sums.size(); ++delay) {
        if (excess(delay, rough_sum) > 10 * excludes) continue;
        sums[delay] = fit.improve(solutions[delay], static_cast<int>(delay), 40, exactly);
    }
    const auto best = static_cast<std::size_t>(std::ranges::min_element(sums) - sums.begin());
    result.delay = result.least_delay = result.most_delay = static_cast<int>(best);
    const Parameters& found = solutions[best];
    if (!(found[0] > 0)) return result;
    const double variance = variance_of(sums[best]);
    for (std::size_t delay = 0; delay < sums.size(); ++delay) {
        if (excess(delay, sums[best]) > excludes) continue;
        result.least_delay = std::min(result.least_delay, static_cast<int>(delay));
        result.most_delay = std::max(result.most_delay, static_cast<int>(delay));
    }
    if (result.most_delay == options.most_delay) {
        result.is_later = true;
        return result;
    }
    const Parameters errors = fit.errors(found, result.delay, variance * count / independent);
    const double mass = 1 / found[0];
    result.mass = {mass, errors[0] * mass * mass};
    result.damping = {found[1] * mass, errors[1] * mass};
    result.friction = {found[2] * mass, errors[2] * mass};
    if (result.friction.value < least_friction) result.friction.value = 0;
    result.stiffness = {found[3] * mass, errors[3] * mass};
    result.weight = found[4] * mass;
    result.residual = std::sqrt(sums[best] / count);
    result.found = true;
    return result;
}

} // namespace proxima
