#include "index/lists/root_frame.h"

#include <algorithm>
#include <cmath>

namespace proxima {

RootFrame make_root_frame(const Box& box, double margin) noexcept
{
    RootFrame frame;
    frame.center = 0.5 * box.lower + 0.5 * box.upper;
    double edge = box.extent().maxCoeff();
    if (!(edge > 0)) {
        constexpr double most_edge = 1e149; // squares of distances within it are numbers
        const double reach = std::max(box.lower.cwiseAbs().maxCoeff(), 1.0);
        edge = std::min(1e-6 * reach, most_edge);
    }
    // The centre is rounded: the cube must hold the box all the same.
    const double reach =
        (box.upper - frame.center).cwiseMax(frame.center - box.lower).maxCoeff() * (1 + 0x1p-50);
    frame.half = std::max(0.5 * edge * (1 + margin), reach);
    int exponent = 0;
    (void)std::frexp(frame.half, &exponent); // half = m 2^exponent, m in [1/2, 1)
    frame.scale = std::ldexp(1.0, -exponent);
    return frame;
}

} // namespace proxima
