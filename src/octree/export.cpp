#include "proxima/octree_io.h"

#include "base/file_extension.h"
#include "base/text.h"

#include <string>

namespace proxima {

Status export_octree(const Octree& octree, const TriangleMesh& mesh,
                     const std::filesystem::path& path, const ExportOptions& options)
{
    const std::string extension = lower_case_extension(path);
    if (extension == ".vtu") return export_vtu(octree, path, options);
    if (extension == ".htg") return export_htg(octree, path, options);
    if (extension == ".ply") return export_ply(octree, path, options);
    if (extension == ".glb") return export_glb(octree, mesh, path, options);
    return fail(
        ErrorCode::unsupported_format,
        concat("octrees are exported as .vtu, .htg, .ply or .glb, not as \"", extension, "\""),
        path.string());
}

} // namespace proxima
