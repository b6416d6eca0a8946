#include "cli/check_octree_file.h"

#include "cli/model_options.h"
#include "cli/names.h"
#include "cli/octree_file_model.h"
#include "cli/statistics_text.h"
#include "octree/check_octree.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace proxima {

Status check_octree_file(const std::string& path, const std::string& mesh, Session& session)
{
    const auto octree = load_octree_file(path, session);
    if (!octree) return tl::unexpected(octree.error());
    const bool has_mesh = !mesh.empty();
    if (has_mesh) {
        const auto loaded = load_mesh_of(*octree, mesh, session);
        if (!loaded) return tl::unexpected(loaded.error());
        const ProgressBar shown(session.progress(), session.bar());
        if (auto status = check_octree(*octree, *loaded, &session.progress()); !status) {
            return at_model(status.error(), path);
        }
    }
    const OctreeParameters& parameters = octree->parameters();
    const OctreeStatistics statistics = octree_statistics(*octree);
    session.print(fmt::format(
        "{}: octree of {} triangles, method {}\n\nchecksums and structure are sound\n{}\n\n{}",
        path, octree->triangle_count(), method_name(parameters.method),
        has_mesh ? fmt::format("every invariant holds against {}", mesh)
                 : "not compared with its mesh: name it with --mesh",
        statistics_text(parameters, statistics)));
    const ClassificationSummary& summary = parameters.classification;
    return session.write_json({{"model", path},
                               {"mesh", has_mesh ? nlohmann::ordered_json(mesh) : nullptr},
                               {"triangles", octree->triangle_count()},
                               {"depth", parameters.max_depth},
                               {"threshold", parameters.threshold},
                               {"method", method_name(parameters.method)},
                               {"uniform", parameters.subdivision == Subdivision::uniform},
                               {"exact", parameters.exact},
                               {"classified", parameters.classified},
                               {"components", summary.components},
                               {"leaked_components", summary.leaked_components},
                               {"leaked_leaves", summary.leaked_leaves},
                               {"total", statistics.total},
                               {"leaves", statistics.leaves},
                               {"references", statistics.references},
                               {"bytes", statistics.bytes}});
}

} // namespace proxima
