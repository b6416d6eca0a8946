#include "octree/check_octree.h"

#include "base/progress.h"
#include "base/text.h"
#include "geometry/triangle_box.h"
#include "octree/check_structure.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace proxima {

namespace {

class InvariantChecker {
public:
    InvariantChecker(const Octree& octree, const TriangleMesh& mesh, Progress* progress)
        : octree_(octree), mesh_(mesh), progress_(progress)
    {
        if (progress_ == nullptr) return;
        progress_->begin_stage("checking the cells", octree.references().size());
    }

    Status run()
    {
        if (octree_.triangle_count() != mesh_.triangle_count()) {
            return bad(octree_.root(), concat("built from ", octree_.triangle_count(),
                                              " triangles, the mesh has ", mesh_.triangle_count()));
        }
        const Box root = octree_.box(octree_.root());
        const Box bounds = bounding_box(mesh_);
        if (!bounds.empty() && !(root.contains(bounds.lower) && root.contains(bounds.upper))) {
            return bad(octree_.root(), "the root does not contain the mesh");
        }
        std::vector<TriangleId> all(mesh_.triangle_count());
        for (std::size_t i = 0; i < all.size(); ++i) {
            all[i] = TriangleId{static_cast<std::uint32_t>(i)};
        }
        return check_cell(octree_.root(), all).map([](const std::vector<TriangleId>&) {});
    }

private:
    static tl::unexpected<Error> bad(const Cell& cell, std::string message)
    {
        const auto at = cell_coordinates(cell.key);
        return fail(ErrorCode::broken_invariant, std::move(message),
                    concat("octree cell (", at[0], ", ", at[1], ", ", at[2], ") at depth ",
                           depth(cell.key)));
    }

    /// Checks the cell and all below. `touching` are the triangles that exactly touch it.
    /// Returns the distinct triangles that leaves below list, ascending.
    Result<std::vector<TriangleId>> check_cell(const Cell& cell,
                                               const std::vector<TriangleId>& touching)
    {
        if (is_cancelled(progress_)) {
            return cancelled("checking the octree");
        }
        std::vector<TriangleId> listed;
        const bool leaf = octree_.is_leaf(cell);
        if (leaf) {
            const auto list = octree_.triangles(cell);
            listed.assign(list.begin(), list.end());
            advance_stage(progress_, listed.size());
            if (const Status status = check_list(cell, listed, touching); !status) {
                return tl::unexpected<Error>(status.error());
            }
        } else {
            for (int octant = 0; octant < 8; ++octant) {
                const Cell child = octree_.child(cell, octant);
                auto below = check_cell(child, touching_of(child, touching));
                if (!below) return below;
                std::vector<TriangleId> both;
                std::set_union(listed.begin(), listed.end(), below->begin(), below->end(),
                               std::back_inserter(both));
                listed = std::move(both);
            }
        }
        if (const Status status = check_subdivision(cell, leaf, listed.size()); !status) {
            return tl::unexpected<Error>(status.error());
        }
        return listed;
    }

    [[nodiscard]] std::vector<TriangleId> touching_of(const Cell& cell,
                                                      const std::vector<TriangleId>& ids) const
    {
        const Box box = octree_.box(cell);
        std::vector<TriangleId> touching;
        std::copy_if(ids.begin(), ids.end(), std::back_inserter(touching),
                     [&](TriangleId id) { return triangle_overlaps_box(mesh_.triangle(id), box); });
        return touching;
    }

    [[nodiscard]] Status check_list(const Cell& cell, const std::vector<TriangleId>& listed,
                                    const std::vector<TriangleId>& touching) const
    {
        if (listed.empty() != (cell.type != CellClass::boundary)) {
            return bad(cell, "a leaf is boundary iff triangles touch it");
        }
        if (!listed.empty() || octree_.parameters().classified) {
            if (cell.type == CellClass::unclassified) return bad(cell, "a leaf has no class");
        }
        std::vector<TriangleId> difference;
        std::set_difference(touching.begin(), touching.end(), listed.begin(), listed.end(),
                            std::back_inserter(difference));
        if (!difference.empty()) {
            return bad(cell, concat("triangle ", to_index(difference.front()),
                                    " touches the leaf and is not listed"));
        }
        if (octree_.parameters().exact && listed.size() != touching.size()) {
            std::set_difference(listed.begin(), listed.end(), touching.begin(), touching.end(),
                                std::back_inserter(difference));
            return bad(cell, concat("triangle ", to_index(difference.front()),
                                    " is listed and does not touch the leaf"));
        }
        return {};
    }

    [[nodiscard]] Status check_subdivision(const Cell& cell, bool leaf, std::size_t count) const
    {
        const OctreeParameters& parameters = octree_.parameters();
        const bool crowded =
            parameters.subdivision == Subdivision::uniform || count > parameters.threshold;
        if (leaf == (crowded && depth(cell.key) < parameters.max_depth)) {
            return bad(cell,
                       concat("a cell of ", count, " triangles is ", leaf ? "not split" : "split",
                              ", the threshold is ", parameters.threshold));
        }
        return {};
    }

    const Octree& octree_;
    const TriangleMesh& mesh_;
    Progress* progress_;
};

} // namespace

Status check_octree(const Octree& octree, const TriangleMesh& mesh, Progress* progress)
{
    if (Status status = check_structure(octree, progress); !status) return status;
    return InvariantChecker(octree, mesh, progress).run();
}

} // namespace proxima
