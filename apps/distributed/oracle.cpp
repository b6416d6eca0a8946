#include "distributed/oracle.h"

#include "base/text.h"
#include "distributed/mesh_input.h"

namespace proxima {

tl::unexpected<Error> answer_differs(std::string_view what, std::string_view question,
                                     std::uint64_t row)
{
    return fail(ErrorCode::broken_invariant,
                concat(what, " of ", question, " ", row,
                       " differs from that of one process: this is a bug, report it"));
}

Result<MeshIndex> index_of_whole(const std::string& model)
{
    const auto mesh = whole_mesh(model);
    if (!mesh) return tl::unexpected(mesh.error());
    return build_mesh_index(*mesh, {.execution = {.threads = {1}}});
}

} // namespace proxima
