#include "viewer/view_models.h"

#include "base/memory_budget.h"
#include "base/progress.h"
#include "base/text.h"
#include "cli/model_options.h"
#include "cli/read_model.h"
#include "proxima/cast_ray.h"
#include "proxima/execution.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "viewer/scene_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace proxima {
namespace {

/// Bytes that showing a triangle takes at most: mesh, topology, mesh index, two
/// scenes, and the larger of their buffers.
constexpr std::uint64_t bytes_per_triangle = 1100;

constexpr std::array model_colors = {0xE9E1D2U, 0xCFDDEBU, 0xD9E8D0U, 0xEBD5D5U, 0xE3D8EEU};

std::shared_ptr<const DrawnScene> surface_scene(const TriangleMesh& mesh, const Color& color,
                                                Smoothing smoothing)
{
    auto scene = std::make_shared<DrawnScene>();
    add_mesh(*scene, mesh, {.name = "mesh", .color = color, .smoothing = smoothing});
    return scene;
}

/// The edge of an equilateral triangle as large as they are on average.
double edge_of_usual_triangle(const TriangleMesh& mesh)
{
    double doubled = 0.0;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t)
        doubled += scaled_normal(mesh.triangle(TriangleId{t})).norm();
    const auto count = static_cast<double>(std::max<std::size_t>(mesh.triangle_count(), 1));
    return std::sqrt(2.0 / std::numbers::sqrt3 * doubled / count);
}

/// The corner or side of the triangle that a point of it is near, or its face.
Feature nearest_part(const ViewModel& model, TriangleId id, const RayHit& hit)
{
    constexpr double near_corner = 0.8; // barycentric
    constexpr double near_side = 0.1;
    const std::array<double, 3> weights = {1.0 - hit.u - hit.v, hit.u, hit.v};
    const TriangleCorners& corners = model.mesh.triangles()[to_index(id)];
    for (std::size_t k = 0; k < 3; ++k)
        if (weights[k] > near_corner) return {FeatureKind::vertex, corners[k]};
    for (std::size_t k = 0; k < 3; ++k) {
        const EdgeId edge = model.topology.edges(id)[(k + 1) % 3];
        if (weights[k] < near_side && edge != no_edge)
            return {FeatureKind::edge, static_cast<std::uint32_t>(edge)};
    }
    return {FeatureKind::face, to_index(id)};
}

} // namespace

Result<std::shared_ptr<const ViewModel>> make_view_model(std::string name, TriangleMesh mesh,
                                                         const Vec3& up, std::size_t number,
                                                         const Execution& context)
{
    if (Status fits = check_budget(context.budget, bytes_per_triangle * mesh.triangle_count(),
                                   concat("showing ", mesh.triangle_count(), " triangles"),
                                   "show a coarser mesh");
        !fits) {
        return at_model(fits.error(), name);
    }
    auto topology = build_topology(mesh, {.execution = context});
    if (!topology) return at_model(topology.error(), name);
    auto rays = build_mesh_index(mesh, {.execution = context});
    if (!rays) return at_model(rays.error(), name);
    auto model = std::make_shared<ViewModel>();
    for (const Vec3& position : mesh.positions()) model->box.extend(position);
    model->edge = edge_of_usual_triangle(mesh);
    model->up = up;
    model->color = srgb(model_colors[number % model_colors.size()]);
    StageSteps steps(context.progress, "shading the surface", 2, 1);
    model->flat = surface_scene(mesh, model->color, Smoothing::flat);
    if (!steps.done(1)) return cancelled("shading the surface", name);
    model->smooth = surface_scene(mesh, model->color, Smoothing::smooth);
    if (!steps.done(1)) return cancelled("shading the surface", name);
    model->name = std::move(name);
    model->mesh = std::move(mesh);
    model->topology = std::move(*topology);
    model->rays = *rays;
    return model;
}

Result<ViewModels> load_view_models(std::span<const std::string> names, Primitives primitives,
                                    const Execution& context, ViewModels before,
                                    const std::optional<Vec3>& up)
{
    ViewModels models = std::move(before);
    for (const std::string& name : names) {
        auto mesh = read_model(name, primitives, context);
        if (!mesh) return tl::unexpected(mesh.error());
        const bool may_be_points = may_be_of_points(name, primitives, *mesh);
        auto model = make_view_model(name, std::move(*mesh), up.value_or(up_axis_of_model(name)),
                                     models.size(), context);
        if (!model) {
            if (may_be_points) model.error().message += points_hint;
            return tl::unexpected(model.error());
        }
        models.push_back(std::move(*model));
    }
    return models;
}

Box bounding_box(const ViewModels& models)
{
    Box box;
    for (const auto& model : models) {
        box.extend(model->box.lower);
        box.extend(model->box.upper);
    }
    return box;
}

std::optional<PickedPoint> pick(const ViewModels& models, const Ray& ray)
{
    std::optional<PickedPoint> best;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < models.size(); ++i) {
        const auto hit = closest_hit(models[i]->rays, ray);
        if (!hit || hit->t >= nearest) continue;
        nearest = hit->t;
        best = PickedPoint{i, hit->triangle, ray.at(hit->t),
                           nearest_part(*models[i], hit->triangle, *hit)};
    }
    return best;
}

} // namespace proxima
