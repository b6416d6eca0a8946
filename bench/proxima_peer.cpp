#include "proxima_peer.h"

namespace proxima::bench {

Result<std::unique_ptr<Contender>> make_proxima_peer(const TriangleMesh& /*mesh*/,
                                                     double /*bytes_per_triangle*/)
{
    return fail(ErrorCode::invalid_argument, "the proximity octree takes no queries yet",
                "proxima");
}

} // namespace proxima::bench
