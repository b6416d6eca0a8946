// Which instruction set the vector code runs on. Kernels are compiled for several by Highway and
// chosen at run time; every choice gives the same bits, and tests run them all.
#pragma once

#include "proxima/result.h"

#include <cstdint>
#include <string>
#include <vector>

namespace proxima {

/// One instruction set that this build has code for and this machine can run.
struct SimdTarget {
    std::int64_t id = 0; ///< Highway's target bit
    std::string name;    ///< for example "AVX3"
};

/// All targets that can run here, best first.
[[nodiscard]] std::vector<SimdTarget> simd_targets();

/// The target that kernels use now.
[[nodiscard]] std::string current_simd_target();

/// Kernels use the instruction set of that name from now on, in the whole process. Error:
/// invalid_argument, naming those there are, where this build or this machine has none of that name.
/// Not thread safe.
[[nodiscard]] Status choose_simd_target(const std::string& name);

/// For tests: uses only `target` from now on, in the whole process, until restore_simd_targets().
/// Not thread safe.
void force_simd_target(const SimdTarget& target);

/// For tests: back to the best target.
void restore_simd_targets();

} // namespace proxima
