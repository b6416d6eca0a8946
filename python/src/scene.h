// The methods of Scene, by question. Each file adds its own to the class.
#pragma once

#include "arrays.h"
#include "bindings.h"
#include "proxima/scene.h"

#include <cstdint>

namespace proxima::python {

/// The bits of an argument: an integer from 0 to 2^32 - 1.
[[nodiscard]] std::uint32_t layers_of(const py::object& object, const char* name);

/// The ids of instances, (n,) int32.
[[nodiscard]] py::array instances_of(std::span<const InstanceId> ids);

void bind_scene_queries(py::class_<Scene>& scene);
void bind_scene_pairs(py::class_<Scene>& scene);

} // namespace proxima::python
