// Lines through points on two logarithmic scales.
#pragma once

#include "cli/figure.h"
#include "proxima/geometry.h"

#include <span>
#include <string>
#include <vector>

namespace proxima {

struct PlotSeries {
    std::string name;
    std::vector<Vec2> points; ///< x ascending
};

struct PlotWords {
    std::string title;
    std::vector<std::string> notes; ///< lines below the title
    std::string x;
    std::string y;
};

/// The points of each series, joined in their order, between round numbers of either scale.
/// \pre coordinates are positive and finite, and there is a point
[[nodiscard]] Figure log_plot(std::span<const PlotSeries> series, const PlotWords& words);

} // namespace proxima
