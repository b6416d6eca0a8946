// What a session of touching amounts to, for people and as JSON.
#pragma once

#include "cli/touch_session.h"

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace proxima {

/// Quantiles of times: p50_ns and so on.
[[nodiscard]] nlohmann::ordered_json latency_json(const LatencyHistogram& histogram);

/// What the passivity guard saw and did, or would have done, of so many ticks; in words, empty where
/// all was calm.
[[nodiscard]] std::string swings_text(const SwingReport& swings, Guard guard, std::uint64_t ticks,
                                      double seconds);
/// Likewise as members of an object.
void add_swings_json(nlohmann::ordered_json& json, const SwingReport& swings, Guard guard);

/// What the report is of.
struct TouchReportOf {
    std::string model;
    std::string device;
    bool paced = true;                        ///< by the clock: with an account of the servo loop
    std::optional<std::uint64_t> differences; ///< of a replay
    ForceOptions asked;                       ///< by options: what a device has less of is less
    bool verbose = false;                     ///< all counters, not only those that say something
};

/// Lines; the last ends with a line break.
[[nodiscard]] std::string touch_text(const TouchReportOf& of, const TouchModel& model,
                                     const TouchResult& result);
[[nodiscard]] nlohmann::ordered_json touch_json(const TouchReportOf& of, const TouchModel& model,
                                                const TouchResult& result);

} // namespace proxima
