#include "touch_model.h"

#include "proxima/index_io.h"
#include "proxima/mesh_index.h"
#include "proxima/mesh_io.h"
#include "proxima/sample_meshes.h"

#include <algorithm>
#include <filesystem>

namespace proxima::bench {

namespace {

constexpr double workspace_radius = 0.1; // m, the Phantom Omni's

Status open_index(TouchModel& model, const std::string& path)
{
    auto index = load_index(path);
    if (!index) return tl::unexpected(index.error());
    model.index = *index;
    auto mesh = mesh_of(model.index);
    if (!mesh) return tl::unexpected(mesh.error());
    model.mesh = std::move(*mesh);
    return {};
}

Status build_index(TouchModel& model)
{
    auto index = build_mesh_index(model.mesh);
    if (index) index = with_lists(*index);
    if (!index) return tl::unexpected(index.error());
    model.index = *index;
    return {};
}

Status make_index(TouchModel& model, const std::string& kept)
{
    auto mesh = is_sample_mesh_name(model.name) ? sample_mesh(model.name) : read_mesh(model.name);
    if (!mesh) return tl::unexpected(mesh.error());
    model.mesh = std::move(*mesh);
    if (kept.empty()) return build_index(model);
    std::string file = std::filesystem::path(model.name).filename().string() + ".pxi";
    std::ranges::replace(file, ':', '-');
    const std::string path = (std::filesystem::path(kept) / file).string();
    if (std::filesystem::exists(path)) {
        auto index = load_index(path);
        if (index && check_same_mesh(*index, model.mesh)) {
            model.index = *index;
            return {};
        }
    }
    if (Status status = build_index(model); !status) return status;
    return save_index(model.index, path);
}

} // namespace

Result<std::unique_ptr<TouchModel>> load_touch_model(const std::string& name,
                                                     const std::string& kept)
{
    auto model = std::make_unique<TouchModel>();
    model->name = name;
    const Status status =
        name.ends_with(".pxi") ? open_index(*model, name) : make_index(*model, kept);
    if (!status) return tl::unexpected(status.error());
    auto topology = build_topology(model->mesh);
    if (!topology) return tl::unexpected(topology.error());
    model->topology = std::move(*topology);
    model->surface = std::make_unique<IndexContactSurface>(model->index);
    model->map = fit_workspace(bounding_box(model->mesh), workspace_radius);
    return model;
}

} // namespace proxima::bench
