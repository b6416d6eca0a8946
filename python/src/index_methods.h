// The methods of Index, by question. Each file adds its own to the class.
#pragma once

#include "bindings.h"
#include "proxima/mesh_index.h"
#include "proxima/view_volume.h"
#include "run.h"

#include <cstddef>

namespace proxima::python {

/// Batches from here on run where Ctrl-C can stop them.
inline constexpr std::size_t lengthy_batch = 4096;

[[nodiscard]] inline Duration duration_of(std::size_t queries) noexcept
{
    return queries < lengthy_batch ? Duration::brief : Duration::lengthy;
}

/// An Index, or that of a Mesh. Cancelled by Ctrl-C. `wanted` says in the message what the model must be.
[[nodiscard]] MeshIndex index_of(const py::object& model, const char* wanted);

/// The volume of planes (n, 4).
[[nodiscard]] ViewVolume volume_of(const py::object& planes);

/// The box of the index's mesh, which is made for it.
[[nodiscard]] inline Box bounds_of(const MeshIndex& index)
{
    return value_of(checked_bounding_box(value_of(mesh_of(index))));
}

void bind_closest(py::class_<MeshIndex>& index);
void bind_rays(py::class_<MeshIndex>& index);
void bind_views(py::module_& module, py::class_<MeshIndex>& index);
void bind_pairs(py::class_<MeshIndex>& index);
void bind_contact(py::class_<MeshIndex>& index);
void bind_near(py::class_<MeshIndex>& index);
void bind_field(py::class_<MeshIndex>& index);
void bind_comparisons(py::module_& module, py::class_<MeshIndex>& index);
void bind_motions(py::module_& module, py::class_<MeshIndex>& index);

} // namespace proxima::python
