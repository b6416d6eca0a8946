#include "minkowski/operation_counts.h"

namespace proxima {

OperationCounts& operation_counts() noexcept
{
    thread_local OperationCounts counts;
    return counts;
}

void reset_operation_counts() noexcept
{
    operation_counts() = {};
}

} // namespace proxima
