// Shares of an area by values that are linear on triangles.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace proxima {

/// Bins of equal widths; what is beyond counts in the last one.
class AreaHistogram {
public:
    AreaHistogram(std::uint32_t bins, double end) : width_(end / bins), areas_(bins) {}

    /// A triangle whose points' values are linear, with these at its corners.
    void add(double area, std::array<double, 3> values)
    {
        if (areas_.empty()) return;
        std::ranges::sort(values);
        const std::size_t last = bin_of(values[2]);
        double before = 0;
        for (std::size_t bin = bin_of(values[0]); bin <= last; ++bin) {
            const double below =
                bin == last ? 1 : part_below(values, width_ * static_cast<double>(bin + 1));
            areas_[bin] += area * (below - before);
            before = below;
        }
    }
    void add(const AreaHistogram& other)
    {
        for (std::size_t i = 0; i < areas_.size(); ++i) areas_[i] += other.areas_[i];
    }
    [[nodiscard]] std::vector<double> shares(double area) const
    {
        std::vector<double> result = areas_;
        for (double& share : result) share /= area;
        return result;
    }

private:
    [[nodiscard]] std::size_t bin_of(double value) const
    {
        const double bin = value / width_;
        const std::size_t last = areas_.size() - 1;
        return bin < static_cast<double>(last) ? static_cast<std::size_t>(bin) : last;
    }
    /// The part of the triangle where the value is below a limit.
    static double part_below(const std::array<double, 3>& values, double limit)
    {
        const auto [a, b, c] = values;
        if (limit <= a) return 0;
        if (limit >= c) return 1;
        if (limit < b) return (limit - a) / (b - a) * ((limit - a) / (c - a));
        return 1 - (c - limit) / (c - b) * ((c - limit) / (c - a));
    }

    double width_;
    std::vector<double> areas_;
};

} // namespace proxima
