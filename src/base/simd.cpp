#include "base/simd.h"

#include "base/text.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "base/simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#if HWY_ONCE

namespace proxima {

namespace {

void refresh_dispatch()
{
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

// The static dispatch table costs 37 us on its first use; pay it before main.
const bool dispatch_is_ready = [] {
    refresh_dispatch();
    return true;
}();

} // namespace

std::vector<SimdTarget> simd_targets()
{
    std::vector<SimdTarget> targets;
    for (const std::int64_t id : hwy::SupportedAndGeneratedTargets()) {
        targets.push_back({id, hwy::TargetName(id)});
    }
    return targets;
}

std::string current_simd_target()
{
    (void)dispatch_is_ready;
    const std::int64_t supported = hwy::SupportedTargets() & HWY_TARGETS;
    // Better targets have lower bits.
    return hwy::TargetName(supported & -supported);
}

Status choose_simd_target(const std::string& name)
{
    std::string known;
    for (const SimdTarget& target : simd_targets()) {
        if (target.name == name) {
            force_simd_target(target);
            return {};
        }
        known += (known.empty() ? "" : ", ") + target.name;
    }
    return fail(ErrorCode::invalid_argument,
                concat("no instruction set ", name, ": this machine has ", known), "simd");
}

void force_simd_target(const SimdTarget& target)
{
    // And the worse ones, which have higher bits: for kernels that have no code for this one.
    hwy::SetSupportedTargetsForTest(0);
    hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & ~(target.id - 1));
    refresh_dispatch();
}

void restore_simd_targets()
{
    hwy::SetSupportedTargetsForTest(0);
    refresh_dispatch();
}

} // namespace proxima

#endif
