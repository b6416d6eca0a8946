#include "cli/closest_searcher.h"

#include "cli/index_file_model.h"
#include "cli/model_options.h"
#include "cli/stopwatch.h"
#include "proxima/mesh_index.h"

namespace proxima {

namespace {

Status load(const std::string& model, Session& session, ClosestSearcher& searcher)
{
    const Stopwatch watch;
    auto index = load_index_file(model, session);
    if (!index) return tl::unexpected(index.error());
    searcher.index = *index;
    searcher.load_seconds = watch.seconds();
    return {};
}

Status build(const std::string& model, const ClosestSearcherOptions& options, Session& session,
             ClosestSearcher& searcher)
{
    const auto mesh = session.load_model(model);
    if (!mesh) return tl::unexpected(mesh.error());
    const Stopwatch watch;
    const ProgressBar shown(session.progress(), session.bar());
    auto index = build_mesh_index(*mesh, {.execution = session.execution()});
    if (index && options.lists) {
        index = with_lists(*index,
                           {.list_bytes = options.list_bytes, .execution = session.execution()});
    }
    if (!index) return at_model(index.error(), model);
    searcher.index = *index;
    searcher.build_seconds = watch.seconds();
    return {};
}

} // namespace

Result<ClosestSearcher> make_closest_searcher(const std::string& model,
                                              const ClosestSearcherOptions& options,
                                              Session& session)
{
    ClosestSearcher searcher;
    const Status status = is_index_file(model) ? load(model, session, searcher)
                                               : build(model, options, session, searcher);
    if (!status) return tl::unexpected(status.error());
    if (!options.is_signed || searcher.index.has_signs()) return searcher;
    const Stopwatch watch;
    const auto index = index_with_signs(searcher.index, model, session);
    if (!index) return tl::unexpected(index.error());
    searcher.index = *index;
    searcher.build_seconds += watch.seconds();
    return searcher;
}

} // namespace proxima
