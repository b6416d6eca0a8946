#include "proxima/thesis.h"

#include "octree/build_octree_with.h"
#include "thesis/octree_generation/build_with_test.h"
#include "thesis/octree_generation/overlap_index_tracking.h"
#include "thesis/octree_generation/overlap_minkowski.h"
#include "thesis/octree_generation/overlap_pairwise.h"
#include "thesis/octree_generation/overlap_separating_axis.h"

#include <algorithm>

namespace proxima {

namespace {

template <OverlapTest Test>
Result<Octree> build_by(const TriangleMesh& mesh, const OverlapChoice& choice,
                        const OctreeOptions& options)
{
    const auto find = [&](const TriangleMesh& checked, const OctreeFrame& frame,
                          const OctreeOptions& used, GrowLimits& limits) {
        return build_with_test<Test>(checked, frame, used, choice.exactness, limits,
                                     [](const Triangle& triangle) { return Test(triangle); });
    };
    return build_octree_with(
        mesh, options,
        {.method = choice.method, .is_exact = choice.exactness == Exactness::exact, .find = find});
}

} // namespace

Result<Octree> build_octree_by(const TriangleMesh& mesh, const OverlapChoice& choice,
                               const OctreeOptions& options)
{
    switch (choice.method) {
    case OverlapMethod::fast:
        return build_octree(mesh, options);
    case OverlapMethod::index_tracking:
        return build_by<IndexTrackingTest>(mesh, choice, options);
    case OverlapMethod::minkowski:
        return build_by<MinkowskiTest>(mesh, choice, options);
    case OverlapMethod::separating_axis:
        return build_by<SeparatingAxisTest>(mesh, choice, options);
    case OverlapMethod::pairwise:
        return build_by<PairwiseTest>(mesh, choice, options);
    }
    return fail(ErrorCode::invalid_argument, "no such overlap method");
}

Result<Octree> build_octree_two_pass(const TriangleMesh& mesh, const OverlapChoice& choice,
                                     const OctreeOptions& options)
{
    OctreeOptions pass = options;
    pass.classification = Classification::none;
    auto first = build_octree_by(mesh, choice, pass);
    if (!first) return first;
    std::uint32_t longest = 0;
    for (const OctreeNode& node : first->nodes()) {
        if (node.is_leaf()) longest = std::max(longest, node.count());
    }
    pass = options;
    pass.threshold = longest;
    return build_octree_by(mesh, choice, pass);
}

} // namespace proxima
