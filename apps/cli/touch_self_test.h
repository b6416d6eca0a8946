// proxima touch --self-test: a person and the motors move a device, and a page says how good it is and
// what to set.
#pragma once

#include "cli/session.h"
#include "cli/touch_options.h"
#include "proxima/result.h"

#include <CLI/App.hpp>
#include <string_view>

namespace proxima {

/// The simulated hand that follows a self-test's instructions.
inline constexpr std::string_view self_test_hand = "hand:self-test";

/// Adds --self-test and --yes.
void add_self_test_options(CLI::App& parser, TouchCommandOptions& options);

/// Error invalid_argument for --yes or the self-test's hand without a self-test, and for options that
/// a self-test does not use.
[[nodiscard]] Status check_self_test_options(const TouchCommandOptions& options);

/// Tests the device, prints the page and writes JSON. Errors: those of opening the device;
/// invalid_argument for a device that is silent, gone or reports what cannot be; cancelled.
[[nodiscard]] Status run_self_test(const TouchCommandOptions& options, Session& session);

} // namespace proxima
