// Table 3.2 of the thesis, measured: what the methods cost at worst, counted while their real code
// runs on counting numbers (operation_counts.h).
//
// Worst cases are the largest flops of many pairs of a triangle and a cube of half size 1: random
// ones, ones of small whole coordinates (parallel to axes, touching, degenerate), near and far.
#pragma once

#include "minkowski/operation_counts.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace proxima {

/// A row of the thesis's Table 3.2. Its 27 cross products of the geometric method are the nine
/// cross products' 27 components; the 440 of the hull are a sum that should be 460.
struct ThesisOperationCounts {
    int dot_products = 0;
    std::optional<int> cross_products;
    int flops = 0;
};

/// A row of our table. Dot and cross products are part of the flops.
struct OperationCountRow {
    std::string method;     ///< as in the thesis where it has such a row
    OperationCounts counts; ///< of the pair with the most flops
    std::optional<ThesisOperationCounts> thesis;
};

struct OperationCountOptions {
    int pairs = 4000; ///< triangle-cube pairs to take the worst of
};

/// The rows of Table 3.2, then ours: general position, index tracking, the closed form of the fast
/// method, constants of a triangle and of a depth. Deterministic; about a quarter of a second by
/// default. Uses the calling thread's counters. \pre options.pairs > 0
[[nodiscard]] std::vector<OperationCountRow>
count_operations(const OperationCountOptions& options = {});

} // namespace proxima
