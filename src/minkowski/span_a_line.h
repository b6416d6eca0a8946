// Whether directions have an unbounded set without corners between them.
#pragma once

#include "proxima/geometry.h"

#include <span>

namespace proxima {

/// Whether a cone of these directions holds a whole line: some of them add up to nothing. Exact.
/// \pre finite, none zero
[[nodiscard]] bool span_a_line(std::span<const Vec3> rays);

} // namespace proxima
