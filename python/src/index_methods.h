// The methods of Index, by question. Each file adds its own to the class.
#pragma once

#include "bindings.h"
#include "proxima/mesh_index.h"
#include "run.h"

#include <cstddef>

namespace proxima::python {

/// Batches from here on run where Ctrl-C can stop them.
inline constexpr std::size_t lengthy_batch = 4096;

[[nodiscard]] inline Duration duration_of(std::size_t queries) noexcept
{
    return queries < lengthy_batch ? Duration::brief : Duration::lengthy;
}

void bind_closest(py::class_<MeshIndex>& index);
void bind_rays(py::class_<MeshIndex>& index);
void bind_views(py::module_& module, py::class_<MeshIndex>& index);
void bind_pairs(py::class_<MeshIndex>& index);
void bind_near(py::class_<MeshIndex>& index);

} // namespace proxima::python
