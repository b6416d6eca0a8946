// Settings of panels by name, as the command line gives them: --set "cut plane=on" --set depth=7.
#pragma once

#include "proxima/result.h"
#include "viewer/controls.h"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace proxima {

/// Offers everything until every setting has found its control: what one control shows may depend
/// on another. Error invalid_argument for what is no NAME=VALUE, for a name that is not offered
/// (which are), whose condition is not met (which it is), and for a value that does not fit (what
/// does).
[[nodiscard]] Status apply_settings(const std::vector<std::string>& settings,
                                    const std::function<void(Controls&)>& offer);

/// What is offered, with values: one line each, "depth = 5 (0 to 12)",
/// with the condition where there is one: "cut at = 0 (-1 to 1), needs cut plane=on".
[[nodiscard]] std::vector<std::string>
describe_controls(const std::function<void(Controls&)>& offer);

} // namespace proxima
