#include "mesh/io/scene_library.h"

#include "mesh/io/read_with_assimp.h"
#include "proxima/export.h"

extern "C" PROXIMA_EXPORT proxima::detail::ReadScene proxima_read_scene;

void proxima_read_scene(const proxima::detail::MeshSource& source,
                        const std::filesystem::path& folder, proxima::MeshFormat format,
                        const proxima::ReadOptions& options, proxima::detail::Vertices vertices,
                        proxima::Result<proxima::TriangleMesh>& mesh)
{
    mesh = proxima::detail::read_with_assimp(source, folder, format, options, vertices);
}
