// What is usual: a god-object over a binary tree of boxes, as haptics libraries have it.
//
//     tree    one triangle to a leaf, split at the median of the longest axis; asked for the first
//             triangle that a segment meets
//     proxy   from where it is towards the device; what is met gives a plane to slide along, a
//             second one the line where both meet, a third one ends it: three segments a tick
//
// Written here, with no friction, radius or guards: a baseline for time alone. It is right for
// triangles that face the proxy and are not too thin for its offset from them.
#pragma once

#include "proxima/geometry.h"
#include "proxima/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace proxima::bench {

class BoxTree {
public:
    struct Hit {
        double t = 0; ///< of the segment: 0 to 1
        std::uint32_t triangle = 0;
    };

    explicit BoxTree(const TriangleMesh& mesh);

    /// The first triangle that the segment meets.
    [[nodiscard]] std::optional<Hit> first_hit(const Vec3& from, const Vec3& to) const;

    [[nodiscard]] const Triangle& triangle(std::uint32_t place) const { return triangles_[place]; }

private:
    struct Node {
        Box box;
        std::uint32_t first = 0; ///< of a leaf its triangle; else its second child, the first one
                                 ///< follows it
        bool is_leaf = false;
    };
    void build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
               const std::vector<Triangle>& all);

    std::vector<Node> nodes_;
    std::vector<Triangle> triangles_; ///< in the order of leaves
};

class GodObject {
public:
    /// Refers to the tree. `offset` is how far it keeps from triangles.
    GodObject(const BoxTree& tree, double offset) : tree_(tree), offset_(offset) {}

    void place(const Vec3& p) { proxy_ = p; }
    /// True where something holds it back.
    bool follow(const Vec3& device);
    [[nodiscard]] const Vec3& proxy() const { return proxy_; }

private:
    const BoxTree& tree_;
    double offset_;
    Vec3 proxy_ = Vec3::Zero();
};

} // namespace proxima::bench
