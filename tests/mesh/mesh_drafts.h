// Meshes to be broken on purpose, and what is reported of them.
#pragma once

#include "proxima/mesh_report.h"
#include "proxima/sample_meshes.h"

#include <limits>
#include <vector>

namespace proxima {

inline constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

// A mesh in the making: the cube or the sum of several, to be broken on purpose.
struct Draft {
    std::vector<Vec3> positions;
    std::vector<TriangleCorners> triangles;

    Draft& add(const TriangleMesh& mesh, const Vec3& shift = Vec3::Zero(), double scale = 1.0)
    {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const Vec3& position : mesh.positions()) positions.push_back(shift + scale * position);
        for (const auto& [a, b, c] : mesh.triangles()) {
            triangles.push_back({first + a, first + b, first + c});
        }
        return *this;
    }
    [[nodiscard]] TriangleMesh mesh() const { return *make_triangle_mesh(positions, triangles); }
};

inline Draft cube_draft()
{
    return Draft().add(make_cube());
}

inline MeshReport report(const TriangleMesh& mesh)
{
    return *report_mesh(mesh);
}
inline MeshReport report(const Draft& draft)
{
    return report(draft.mesh());
}

inline std::vector<FindingKind> kinds(const MeshReport& report)
{
    std::vector<FindingKind> all;
    for (const MeshFinding& finding : report.findings) all.push_back(finding.kind);
    return all;
}

using Kinds = std::vector<FindingKind>;
using Ids = std::vector<std::uint32_t>;

inline Outlook outlook(const MeshReport& report, QueryKind query)
{
    return report.outlook.at(static_cast<std::size_t>(query)).outlook;
}

} // namespace proxima
