#include "proxima/octree/export.h"

#include "proxima/base/text.h"

#include <string>

namespace proxima {

Status export_octree(const Octree& octree, const TriangleMesh& mesh,
                     const std::filesystem::path& path)
{
    std::string extension = path.extension().string();
    for (char& letter : extension) {
        if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
    }
    if (extension == ".vtu") return export_vtu(octree, path);
    if (extension == ".htg") return export_htg(octree, path);
    if (extension == ".ply") return export_ply(octree, path);
    if (extension == ".glb") return export_glb(octree, mesh, path);
    return fail(
        ErrorCode::unsupported_format,
        concat("octrees are exported as .vtu, .htg, .ply or .glb, not as \"", extension, "\""),
        path.string());
}

} // namespace proxima
