#include "god_object_peer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace proxima::bench {

namespace {

/// Where the segment from `from` along `way` enters a box, if it meets it before `most`.
bool meets(const Box& box, const Vec3& from, const Vec3& per_way, double most)
{
    const Eigen::Array3d a = (box.lower - from).array() * per_way.array();
    const Eigen::Array3d b = (box.upper - from).array() * per_way.array();
    const double enter = a.min(b).maxCoeff();
    const double leave = a.max(b).minCoeff();
    return enter <= leave && leave >= 0 && enter <= most;
}

/// Moller and Trumbore, both sides.
std::optional<double> meets(const Triangle& triangle, const Vec3& from, const Vec3& way)
{
    const Vec3 u = triangle[1] - triangle[0];
    const Vec3 w = triangle[2] - triangle[0];
    const Vec3 across = way.cross(w);
    const double determinant = u.dot(across);
    if (determinant == 0) return std::nullopt;
    const double inverse = 1 / determinant;
    const Vec3 apart = from - triangle[0];
    const double a = apart.dot(across) * inverse;
    if (a < 0 || a > 1) return std::nullopt;
    const Vec3 turned = apart.cross(u);
    const double b = way.dot(turned) * inverse;
    if (b < 0 || a + b > 1) return std::nullopt;
    const double t = w.dot(turned) * inverse;
    if (t < 0 || t > 1) return std::nullopt;
    return t;
}

} // namespace

BoxTree::BoxTree(const TriangleMesh& mesh)
{
    std::vector<Triangle> all(mesh.triangle_count());
    for (std::uint32_t id = 0; id < all.size(); ++id) all[id] = mesh.triangle(TriangleId{id});
    std::vector<std::uint32_t> order(all.size());
    std::iota(order.begin(), order.end(), 0U);
    nodes_.reserve(2 * all.size());
    triangles_.reserve(all.size());
    build(order, 0, order.size(), all);
}

void BoxTree::build(std::vector<std::uint32_t>& order, std::size_t begin, std::size_t end,
                    const std::vector<Triangle>& all)
{
    const std::size_t place = nodes_.size();
    nodes_.emplace_back();
    Box box;
    Box middles;
    const auto middle = [&](std::uint32_t id) {
        return Vec3((all[id][0] + all[id][1] + all[id][2]) / 3);
    };
    for (std::size_t i = begin; i < end; ++i) {
        for (const Vec3& corner : all[order[i]].vertices) box.extend(corner);
        middles.extend(middle(order[i]));
    }
    nodes_[place].box = box;
    if (end - begin == 1) {
        nodes_[place].is_leaf = true;
        nodes_[place].first = static_cast<std::uint32_t>(triangles_.size());
        triangles_.push_back(all[order[begin]]);
        return;
    }
    Eigen::Index axis = 0;
    middles.extent().maxCoeff(&axis);
    const std::size_t half = begin + (end - begin) / 2;
    using Offset = std::vector<std::uint32_t>::difference_type;
    std::nth_element(
        order.begin() + static_cast<Offset>(begin), order.begin() + static_cast<Offset>(half),
        order.begin() + static_cast<Offset>(end),
        [&](std::uint32_t a, std::uint32_t b) { return middle(a)[axis] < middle(b)[axis]; });
    build(order, begin, half, all);
    nodes_[place].first = static_cast<std::uint32_t>(nodes_.size());
    build(order, half, end, all);
}

std::optional<BoxTree::Hit> BoxTree::first_hit(const Vec3& from, const Vec3& to) const
{
    const Vec3 way = to - from;
    const Vec3 per_way = way.cwiseInverse(); // infinite along axes it does not move on
    std::array<std::uint32_t, 64> pending;   // NOLINT: a median tree is no deeper than 33
    std::size_t count = 0;
    pending[count++] = 0;
    std::optional<Hit> best;
    while (count > 0) {
        const std::uint32_t at = pending[--count];
        const Node& node = nodes_[at];
        if (!meets(node.box, from, per_way, best ? best->t : 1.0)) continue;
        if (!node.is_leaf) {
            pending[count++] = node.first;
            pending[count++] = at + 1;
            continue;
        }
        const auto t = meets(triangles_[node.first], from, way);
        if (t && (!best || *t < best->t)) best = Hit{*t, node.first};
    }
    return best;
}

bool GodObject::follow(const Vec3& device)
{
    std::array<Vec3, 2> normals;
    Vec3 goal = device;
    for (std::size_t planes = 0; planes < 3; ++planes) {
        const auto hit = tree_.first_hit(proxy_, goal);
        if (!hit) {
            proxy_ = goal;
            return planes > 0;
        }
        const Triangle& triangle = tree_.triangle(hit->triangle);
        Vec3 normal = scaled_normal(triangle).normalized();
        const Vec3 way = goal - proxy_;
        if (normal.dot(way) > 0) normal = -normal;
        const Vec3 met = proxy_ + hit->t * way;
        // Back along the way until it is `offset` above the plane, no farther than where it was.
        const double fall = -normal.dot(way);
        const double back = fall > 0 ? std::min(hit->t, offset_ / fall) : hit->t;
        proxy_ = met - back * way;
        if (planes == 2) return true;
        const Vec3 above = met + offset_ * normal;
        if (planes == 0) {
            goal = device - normal * normal.dot(device - above);
        } else {
            const Vec3 line = normals[0].cross(normal);
            const double squared = line.squaredNorm();
            if (!(squared > 1e-12)) return true;
            goal = proxy_ + line * (line.dot(device - proxy_) / squared);
        }
        normals[planes] = normal;
    }
    return true;
}

} // namespace proxima::bench
