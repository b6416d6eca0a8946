// The columns of a contour.
#pragma once

#include "bindings.h"
#include "proxima/intersect_meshes.h"

namespace proxima::python {

/// A proxima.Contour.
[[nodiscard]] py::object contour_columns(const IntersectionContour& contour);

} // namespace proxima::python
