// The instruction set that a benchmark's kernels use.
#pragma once

#include "base/simd.h"

#include <cstdio>
#include <cstdlib>
#include <string>

namespace proxima::bench {

/// Has kernels use the named instruction set, the best where there is no name, and says on stderr which one
/// they use. False where this machine has none of that name.
inline bool use_instruction_set(const std::string& name)
{
    const Status status = name.empty() ? Status() : choose_simd_target(name);
    (void)std::fprintf(stderr, "%s\n",
                       status ? ("instruction set " + current_simd_target()).c_str()
                              : status.error().message.c_str());
    return status.has_value();
}

/// Calls use_instruction_set with the name that the environment variable PROXIMA_SIMD holds.
inline bool use_instruction_set_asked_for()
{
    const char* const name = std::getenv("PROXIMA_SIMD");
    return use_instruction_set(name == nullptr ? "" : name);
}

} // namespace proxima::bench
