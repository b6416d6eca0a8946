// Settings of panels by name, as the command line gives them: --set "cut plane=on" --set depth=7.
#pragma once

#include "proxima/result.h"
#include "viewer/controls.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace proxima {

/// Offers everything until every setting has found its control: what one control shows may depend
/// on another. Error invalid_argument for what is no NAME=VALUE, for a name that is not offered
/// (which are), whose condition is not met (which it is), and for a value that does not fit (what
/// does).
[[nodiscard]] Status apply_settings(const std::vector<std::string>& settings,
                                    const std::function<void(Controls&)>& offer);

/// Whether settings that were applied before still fit, and changes nothing: with other models fewer
/// values may. Errors as above.
[[nodiscard]] Status check_settings(const std::vector<std::string>& settings,
                                    const std::function<void(Controls&)>& offer);

/// A control in the words of --set.
struct ControlDescription {
    std::string name;
    std::optional<std::string> value; ///< none: a button
    std::string values;               ///< that it may have: "0 to 12", "on, off"
    std::string needs;                ///< its condition, "cut plane=on"; empty without one

    /// "cut at = 0 (-1 to 1), needs cut plane=on"
    [[nodiscard]] std::string text() const;
};

/// What is offered, with the present values.
[[nodiscard]] std::vector<ControlDescription>
describe_controls(const std::function<void(Controls&)>& offer);

} // namespace proxima
