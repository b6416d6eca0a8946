#include "cli/closest_searcher.h"

#include "cli/model_options.h"
#include "cli/stopwatch.h"
#include "index/lists/build_proximity_octree.h"

#include <utility>

namespace proxima {

namespace {

Status load(const std::string& model, const ClosestSearcherOptions& options, Session& session,
            ClosestSearcher& searcher)
{
    const Stopwatch load_watch;
    auto octree = load_proximity_file(model, session);
    if (!octree) return tl::unexpected(octree.error());
    searcher.octree = std::move(*octree);
    searcher.load_seconds = load_watch.seconds();
    if (!options.is_signed) return {};
    const Stopwatch watch;
    auto surface = surface_of(searcher.octree, model, session);
    if (!surface) return tl::unexpected(surface.error());
    searcher.surface = std::move(*surface);
    searcher.build_seconds = watch.seconds();
    return {};
}

Status build(const std::string& model, const ClosestSearcherOptions& options, Session& session,
             ClosestSearcher& searcher)
{
    auto mesh = session.load_model(model);
    if (!mesh) return tl::unexpected(mesh.error());
    const Stopwatch watch;
    auto surface = surface_of(std::move(*mesh), model, session);
    if (!surface) return tl::unexpected(surface.error());
    searcher.surface = std::move(*surface);
    const ProgressBar shown(session.progress(), session.bar());
    auto octree = build_proximity_octree(
        searcher.surface.mesh, searcher.surface.topology,
        {.budget_bytes = options.budget_bytes, .execution = session.execution()});
    if (!octree) return at_model(octree.error(), model);
    searcher.octree = std::move(*octree);
    searcher.build_seconds = watch.seconds();
    return {};
}

} // namespace

Result<std::unique_ptr<ClosestSearcher>>
make_closest_searcher(const std::string& model, const ClosestSearcherOptions& options,
                      Session& session)
{
    auto searcher = std::make_unique<ClosestSearcher>();
    const Status status = is_proximity_file(model) ? load(model, options, session, *searcher)
                                                   : build(model, options, session, *searcher);
    if (!status) return tl::unexpected(status.error());
    if (!options.is_signed) return searcher;
    const Stopwatch watch;
    const ProgressBar shown(session.progress(), session.bar());
    auto sign = build_surface_sign(searcher->surface.mesh, searcher->surface.topology,
                                   {.execution = session.execution()});
    if (!sign) return at_model(sign.error(), model);
    searcher->sign = std::move(*sign);
    searcher->build_seconds += watch.seconds();
    return searcher;
}

} // namespace proxima
