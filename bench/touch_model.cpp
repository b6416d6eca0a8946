#include "touch_model.h"

#include "index/file/proximity_file.h"
#include "index/lists/build_proximity_octree.h"
#include "index/lists/octree_mesh.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <filesystem>

namespace proxima::bench {

namespace {

constexpr double workspace_radius = 0.1; // m, the Phantom Omni's

Status open_octree(TouchModel& model, const std::string& path)
{
    auto octree = load_proximity_octree(path);
    if (!octree) return tl::unexpected(octree.error());
    model.octree = std::move(*octree);
    auto mesh = mesh_of(model.octree);
    if (!mesh) return tl::unexpected(mesh.error());
    model.mesh = std::move(*mesh);
    return {};
}

Status build_octree(TouchModel& model)
{
    auto octree = build_proximity_octree(model.mesh);
    if (!octree) return tl::unexpected(octree.error());
    model.octree = std::move(*octree);
    return {};
}

Status make_octree(TouchModel& model, const std::string& kept)
{
    auto mesh = is_sample_mesh_name(model.name) ? sample_mesh(model.name) : read_mesh(model.name);
    if (!mesh) return tl::unexpected(mesh.error());
    model.mesh = std::move(*mesh);
    if (kept.empty()) return build_octree(model);
    std::string file = std::filesystem::path(model.name).filename().string() + ".pxp";
    std::ranges::replace(file, ':', '-');
    const std::string path = (std::filesystem::path(kept) / file).string();
    if (std::filesystem::exists(path)) {
        auto octree = load_proximity_octree(path);
        if (octree && check_same_mesh(*octree, model.mesh)) {
            model.octree = std::move(*octree);
            return {};
        }
    }
    if (Status status = build_octree(model); !status) return status;
    return save_proximity_octree(model.octree, path);
}

} // namespace

Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& name,
                                                     const std::string& kept)
{
    auto model = std::make_unique<TouchModel>();
    model->name = name;
    const Status status =
        name.ends_with(".pxp") ? open_octree(*model, name) : make_octree(*model, kept);
    if (!status) return tl::unexpected(status.error());
    auto topology = build_topology(model->mesh);
    if (!topology) return tl::unexpected(topology.error());
    model->topology = std::move(*topology);
    model->surface = std::make_unique<OctreeContactSurface>(model->octree);
    model->map = fit_workspace(bounding_box(model->mesh), workspace_radius);
    return model;
}

} // namespace proxima::bench
