// The models that a window shows, with what every panel needs of them.
#pragma once

#include "proxima/execution.h"
#include "proxima/geometry.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/result.h"
#include "proxima/topology.h"
#include "viewer/layers.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace proxima {

/// Immutable.
struct ViewModel {
    std::string name;
    TriangleMesh mesh;
    Topology topology;
    MeshIndex rays; ///< for picking
    Box box;
    double edge = 0.0; ///< about as long as its edges are
    Vec3 up = Vec3::UnitZ();
    Color color = Color::Ones();
    std::shared_ptr<const DrawnScene> flat;   ///< a normal per triangle
    std::shared_ptr<const DrawnScene> smooth; ///< normals blended where triangles are bent little
};

using ViewModels = std::vector<std::shared_ptr<const ViewModel>>;

/// Files or built-ins, each in a colour of its own, after those there are. `up` holds for all, where
/// it is given, and else what is usual for such a model. Errors: those of
/// reading; budget_exceeded where showing it would take more memory than the budget; invalid_mesh
/// (empty, NaN); cancelled. Error::where names the model.
[[nodiscard]] Result<ViewModels> load_view_models(std::span<const std::string> names,
                                                  Primitives primitives, const Execution& context,
                                                  ViewModels before = {},
                                                  const std::optional<Vec3>& up = {});

/// A mesh that is there already, as model number `number`. Errors as above.
[[nodiscard]] Result<std::shared_ptr<const ViewModel>>
make_view_model(std::string name, TriangleMesh mesh, const Vec3& up, std::size_t number,
                const Execution& context);

/// Of all.
[[nodiscard]] Box bounding_box(const ViewModels& models);

/// The first triangle of any model that a ray meets.
struct PickedPoint {
    std::size_t model = 0;
    TriangleId triangle{};
    Vec3 point = Vec3::Zero();
    Feature
        nearest; ///< of the triangle, to the point: a vertex within a fifth of it, an edge within a tenth
};
[[nodiscard]] std::optional<PickedPoint> pick(const ViewModels& models, const Ray& ray);

} // namespace proxima
