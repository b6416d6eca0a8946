#include "haptics/device/encoder_step.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace proxima {

namespace {

constexpr std::size_t least_changes = 20;

/// m: smaller changes of position are rounding.
constexpr double least_change = 1e-12;

/// Larger multiples say little of the step, and a wrong one changes their number.
constexpr double largest_multiple = 20;

/// Nine tenths of the changes are no farther than this from multiples, in steps. A twentieth of a step
/// of error in each position makes 0.116; changes that have nothing to do with the step, 0.45.
constexpr double largest_residual = 0.13;
/// For a step that no change shows by itself.
constexpr double largest_residual_of_parts = 0.05;

/// The step of which nearly all changes are multiples, near a candidate; nothing where they are not.
std::optional<double> fit_grid(std::span<const double> changes, double step, double largest)
{
    std::size_t used = 0;
    for (int round = 0; round < 3; ++round) {
        double product = 0;
        double squares = 0;
        used = 0;
        for (const double change : changes) {
            const double multiple = std::round(change / step);
            if (multiple < 1 || multiple > largest_multiple) continue;
            product += multiple * change;
            squares += multiple * multiple;
            ++used;
        }
        if (used < least_changes / 2) return std::nullopt;
        step = product / squares;
    }
    // Not the largest, so that a few changes that are no multiples do not matter.
    std::vector<double> off;
    off.reserve(used);
    for (const double change : changes) {
        const double multiple = std::round(change / step);
        if (multiple <= largest_multiple) off.push_back(std::abs(change / step - multiple));
    }
    const auto most = off.begin() + static_cast<std::ptrdiff_t>(off.size() * 9 / 10);
    std::ranges::nth_element(off, most);
    return *most <= largest ? std::optional(step) : std::nullopt;
}

} // namespace

EncoderStep estimate_encoder_step(std::span<const double> positions)
{
    EncoderStep result;
    std::vector<double> changes;
    for (std::size_t i = 1; i < positions.size(); ++i) {
        const double change = std::abs(positions[i] - positions[i - 1]);
        if (change >= least_change) changes.push_back(change);
    }
    result.changes = changes.size();
    if (changes.size() < least_changes) return result;
    std::ranges::sort(changes);
    result.least_change = changes.front();
    // Beyond the few that may be no multiples, the least change is one step, or a few where none was
    // as small as that.
    const double candidate = changes[changes.size() * 3 / 100];
    for (int parts = 1; parts <= 4; ++parts) {
        const double largest = parts == 1 ? largest_residual : largest_residual_of_parts;
        if (const auto step = fit_grid(changes, candidate / parts, largest)) {
            result.kind = StepKind::grid;
            result.step = *step;
            return result;
        }
    }
    const auto pairs = static_cast<double>(positions.size() - 1);
    if (static_cast<double>(changes.size()) > 0.95 * pairs) {
        result.kind = StepKind::invisible;
        return result;
    }
    result.kind = StepKind::uneven;
    result.step = changes[changes.size() * 9 / 10];
    return result;
}

} // namespace proxima
