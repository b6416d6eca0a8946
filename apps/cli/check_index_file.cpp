#include "cli/check_index_file.h"

#include "cli/index_file_model.h"
#include "cli/model_options.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "lab/query_sets.h"
#include "proxima/mesh_index.h"
#include "query/closest/check_answers.h"

#include <algorithm>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

constexpr std::uint64_t points_seed = 1;

/// Near, on and about the surface; as many as take some seconds on one thread.
std::vector<Vec3> points_to_ask(const ModelSurface& surface)
{
    constexpr std::size_t asked_features = 200'000'000; // 5 ns each
    const std::size_t features = surface.topology.vertex_count() + surface.topology.edge_count() +
                                 surface.topology.triangle_count();
    const std::size_t count = std::clamp<std::size_t>(asked_features / 3 / features, 20, 1000);
    std::vector<Vec3> points;
    for (const QuerySet& set : query_sets(surface.mesh, count, points_seed))
        points.insert(points.end(), set.points.begin(), set.points.end());
    return points;
}

Status check_mesh_of(const MeshIndex& index, const std::string& mesh, Session& session)
{
    const auto loaded = session.load_model(mesh);
    if (!loaded) return tl::unexpected(loaded.error());
    if (const Status status = check_same_mesh(index, *loaded); !status)
        return at_model(status.error(), mesh);
    return {};
}

/// A line for each addition: lists, slabs and signs.
std::string additions_text(const MeshIndex& index, const ProximityStatistics& counts)
{
    const MeshIndexBytes bytes = bytes_of(index);
    const auto size_text = [](std::uint64_t size) {
        return size == 0 ? std::string("none") : fmt::format("{} bytes", size);
    };
    std::string lists = "lists: " + size_text(bytes.lists);
    if (index.has_lists()) {
        lists += fmt::format(" for {} leaves down to depth {}, {} of them without a list; {} "
                             "entries in all, {} in the longest list",
                             counts.leaves, counts.max_depth, counts.searched_leaves,
                             counts.references, counts.max_list);
    }
    return fmt::format("{}\nslabs: {}\nsigns: {}\n", lists, size_text(bytes.slabs),
                       size_text(bytes.signs));
}

} // namespace

Status check_index_file(const std::string& path, const std::string& mesh, Session& session)
{
    const auto index = load_index_file(path, session);
    if (!index) return tl::unexpected(index.error());
    const bool has_mesh = !mesh.empty();
    if (has_mesh) {
        if (Status status = check_mesh_of(*index, mesh, session); !status) return status;
    }
    const auto surface = surface_of(*index, path, session);
    if (!surface) return tl::unexpected(surface.error());
    const std::vector<Vec3> points = points_to_ask(*surface);
    {
        const ProgressBar shown(session.progress(), session.bar());
        const Status status = check_answers(*index, surface->mesh, surface->topology, points,
                                            {.execution = session.execution()});
        if (!status) return at_model(status.error(), path);
    }
    const ProximityStatistics counts =
        index->has_lists() ? index->parts().lists()->statistics() : ProximityStatistics{};
    session.print(
        fmt::format("{}: index of {} triangles, {} bytes\n{}\nchecksums and structure are sound\n"
                    "answers at {} points are those of all triangles, up to rounding\n{}\n",
                    path, surface->mesh.triangle_count(), index->bytes(),
                    additions_text(*index, counts), points.size(),
                    has_mesh ? fmt::format("it was built from {}", mesh)
                             : "not compared with its mesh: name it with --mesh"));
    return session.write_json({{"model", path},
                               {"mesh", has_mesh ? nlohmann::ordered_json(mesh) : nullptr},
                               {"triangles", surface->mesh.triangle_count()},
                               {"points", points.size()},
                               {"nodes", counts.nodes},
                               {"leaves", counts.leaves},
                               {"searched_leaves", counts.searched_leaves},
                               {"references", counts.references},
                               {"max_depth", counts.max_depth},
                               {"max_list", counts.max_list},
                               {"bytes", index->bytes()}});
}

} // namespace proxima
