// The octree that a query panel asks: depth and threshold as settings, built when they change.
#pragma once

#include "proxima/execution.h"
#include "proxima/octree.h"
#include "viewer/panel.h"

#include <algorithm>
#include <compare>
#include <memory>

namespace proxima {

struct OctreeChoice {
    int model = 1; ///< from 1
    int depth = 5;
    int threshold = 16;
    friend auto operator<=>(const OctreeChoice&, const OctreeChoice&) = default;

    void offer(Controls& controls)
    {
        controls.number("depth", depth, 0, 12);
        controls.number("threshold", threshold, 1, 1000);
    }
};

using KeptOctree = Kept<OctreeChoice, Octree>;

[[nodiscard]] inline Result<std::shared_ptr<const Octree>> octree_of(KeptOctree& kept,
                                                                     const OctreeChoice& choice,
                                                                     const ViewModel& model,
                                                                     const Execution& context)
{
    return kept.get(choice, [&] {
        return build_octree(model.mesh, {.max_depth = choice.depth,
                                         .threshold = static_cast<std::uint32_t>(choice.threshold),
                                         .execution = context});
    });
}

} // namespace proxima
