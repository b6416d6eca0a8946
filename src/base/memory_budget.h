// Memory limits of operations whose size grows with their options.
#pragma once

#include "proxima/execution.h"
#include "proxima/result.h"

#include <cstdint>
#include <string_view>

namespace proxima {

/// The limit in bytes that `budget` stands for.
[[nodiscard]] std::uint64_t budget_bytes(MemoryBudget budget);

/// An error that names both figures and what to change unless `needed` bytes fit the budget.
/// `what` names the consumer, `advice` what to do: "lower the depth or raise the budget".
[[nodiscard]] Status check_budget(MemoryBudget budget, std::uint64_t needed, std::string_view what,
                                  std::string_view advice);

} // namespace proxima
