// The check that batches of queries have in common.
#pragma once

#include "base/text.h"
#include "proxima/result.h"

#include <cstddef>
#include <string_view>

namespace proxima {

/// Error invalid_argument where a list of answers is longer or shorter than that of the questions,
/// which are `questions`: "points", "rays".
[[nodiscard]] inline Status check_batch_size(std::size_t answers, std::size_t count,
                                             std::string_view questions)
{
    if (answers == count) return {};
    return fail(ErrorCode::invalid_argument,
                concat("a list of ", answers, " answers, but ", count, " ", questions));
}

} // namespace proxima
