#include "haptics/tool/tool_contacts.h"

#include "geometry/closest_point.h"

#include <array>
#include <cmath>
#include <optional>

namespace proxima {

namespace {

/// Sine of the angle by which a neighbour may be on the near side of a contact, for rounding.
constexpr double near_side = 1e-7;
/// Sine of the angle by which a neighbour of two edges that cross may be on the near side of their contact.
constexpr double near_side_of_crossings = 0.01;
/// Sine of the angle below which edges count as parallel: their ends are the contacts.
constexpr double parallel = 1e-6;

/// Whether no neighbour is nearer along the normal than the feature's point, but for that sine.
bool is_nearest(const PlacedFeatures& mesh, std::span<const std::uint32_t> neighbours,
                const Vec3& point, const Vec3& normal, double sine) noexcept
{
    for (const std::uint32_t each : neighbours) {
        const Vec3 to = mesh.pose(mesh.features->position(each)) - point;
        if (normal.dot(to) > sine * to.norm()) return false;
    }
    return true;
}

/// Whether a point is near a triangle: near its plane, and not clearly beside it. Rules out most points
/// for a tenth of what a closest point costs.
class TriangleFilter {
public:
    TriangleFilter(const Triangle& triangle, double farthest) noexcept
        : triangle_(triangle), farthest_(farthest), normal_(scaled_normal(triangle)),
          length_(normal_.norm())
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 side = triangle.vertices[(k + 1) % 3] - triangle.vertices[k];
            inward_[k] = normal_.cross(side);
            // A foot may be off the triangle by near_side times the distance.
            slack_[k] = length_ * (side.norm() * 1e-6 * farthest + 1e-9 * side.squaredNorm());
        }
    }
    [[nodiscard]] bool may_have_foot(const Vec3& p) const noexcept
    {
        const double height = std::abs(normal_.dot(p - triangle_.vertices[0]));
        if (height > farthest_ * length_ * (1 + 1e-9)) return false;
        for (std::size_t k = 0; k < 3; ++k)
            if (inward_[k].dot(p - triangle_.vertices[k]) < -slack_[k]) return false;
        return true;
    }

private:
    const Triangle& triangle_;
    double farthest_;
    Vec3 normal_;
    double length_;
    std::array<Vec3, 3> inward_;
    std::array<double, 3> slack_ = {};
};

Segment side_of(const Triangle& triangle, std::size_t k) noexcept
{
    return {triangle.vertices[k], triangle.vertices[(k + 1) % 3]};
}

/// The contacts of one pair.
class ContactFinder {
public:
    ContactFinder(const NearPair& pair, const PlacedFeatures& scene, const PlacedFeatures& tool,
                  double farthest, std::span<FeatureContact> contacts) noexcept
        : scene_(scene), tool_(tool), scene_row_(scene.features->row(pair.scene_row)),
          tool_row_(tool.features->row(pair.tool_row)), on_scene_(pair.scene),
          on_tool_(tool.pose(pair.tool)), farthest_(farthest), contacts_(contacts)
    {}

    std::size_t find() noexcept
    {
        if (tool_row_.owned_vertices != 0) find_on_scene_face();
        if (scene_row_.owned_vertices != 0) find_on_tool_face();
        if (tool_row_.owns_any() && scene_row_.owns_any()) find_of_edges();
        return count_;
    }

private:
    void find_on_scene_face() noexcept
    {
        const TriangleFilter filter(on_scene_, farthest_);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& corner = on_tool_.vertices[k];
            if ((tool_row_.owned_vertices >> k & 1) == 0 || !filter.may_have_foot(corner)) continue;
            if (const auto foot = foot_on(on_scene_, corner)) add(*foot, corner, {});
        }
    }
    void find_on_tool_face() noexcept
    {
        const TriangleFilter filter(on_tool_, farthest_);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& vertex = on_scene_.vertices[k];
            if ((scene_row_.owned_vertices >> k & 1) == 0 || !filter.may_have_foot(vertex))
                continue;
            if (const auto foot = foot_on(on_tool_, vertex)) add(vertex, *foot, {.turns = true});
        }
    }
    void find_of_edges() noexcept
    {
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const bool scene_edge = (scene_row_.owned_edges >> i & 1) != 0;
                const bool tool_edge = (tool_row_.owned_edges >> k & 1) != 0;
                const bool scene_vertex = (scene_row_.owned_vertices >> i & 1) != 0;
                const bool tool_vertex = (tool_row_.owned_vertices >> k & 1) != 0;
                if (scene_edge && tool_edge) try_edges(i, k);
                if (scene_edge && tool_vertex) try_tool_vertex(i, k);
                if (scene_vertex && tool_edge) try_scene_vertex(i, k);
                if (scene_vertex && tool_vertex) try_vertices(i, k);
            }
        }
    }

    /// The foot of p on the triangle's plane where that is on the triangle, its border included.
    [[nodiscard]] static std::optional<Vec3> foot_on(const Triangle& triangle,
                                                     const Vec3& p) noexcept
    {
        const Vec3 foot = closest_point(triangle, p).point;
        const Vec3 normal = scaled_normal(triangle);
        const Vec3 across = p - foot;
        if (across.cross(normal).norm() > near_side * across.norm() * normal.norm())
            return std::nullopt;
        return foot;
    }

    /// The vector from the scene's point to the tool's, of length 1; nothing where it is out of reach.
    [[nodiscard]] std::optional<Vec3> direction(const Vec3& scene, const Vec3& tool) const noexcept
    {
        const Vec3 across = tool - scene;
        const double distance = across.norm();
        if (!(distance > 0 && distance <= farthest_)) return std::nullopt;
        return Vec3(across / distance);
    }
    /// Takes a contact at these points, with what else is told of it.
    void add(const Vec3& scene, const Vec3& tool, FeatureContact contact) noexcept
    {
        const auto normal = direction(scene, tool);
        if (!normal || count_ == contacts_.size()) return;
        contact.scene_point = scene;
        contact.tool_point = tool;
        contact.normal = *normal;
        contact.gap = (tool - scene).norm();
        contacts_[count_++] = contact;
    }

    void try_edges(std::size_t i, std::size_t k) noexcept
    {
        const Segment first = side_of(on_scene_, i);
        const Segment second = side_of(on_tool_, k);
        const Vec3 u = first.to - first.from;
        const Vec3 w = second.to - second.from;
        const Vec3 across = u.cross(w);
        const double squared = across.squaredNorm();
        if (!(squared > parallel * parallel * u.squaredNorm() * w.squaredNorm())) return;
        // Their lines are too far apart, or nearest far off an end, with room for rounding.
        const Vec3 between = second.from - first.from;
        const double height = between.dot(across);
        if (height * height > farthest_ * farthest_ * squared * (1 + 1e-6)) return;
        const auto is_off = [&](double t) { return t < -0.01 * squared || t > 1.01 * squared; };
        if (is_off(between.cross(w).dot(across)) || is_off(between.cross(u).dot(across))) return;
        const SegmentPair nearest = closest_points(first, second);
        const bool inside = nearest.first.t > 0 && nearest.first.t < 1 && nearest.second.t > 0 &&
                            nearest.second.t < 1;
        if (!inside) return;
        const auto normal = direction(nearest.first.point, nearest.second.point);
        if (!normal || !is_scene_edge(i, nearest.first.point, *normal, near_side_of_crossings) ||
            !is_tool_edge(k, nearest.second.point, *normal, near_side_of_crossings))
            return;
        add(nearest.first.point, nearest.second.point,
            {.scene_edge = u.normalized(), .tool_edge = w.normalized()});
    }
    void try_tool_vertex(std::size_t i, std::size_t k) noexcept
    {
        const Vec3& vertex = on_tool_.vertices[k];
        const SegmentPoint foot = closest_point(side_of(on_scene_, i), vertex);
        if (!(foot.t > 0 && foot.t < 1)) return;
        const auto normal = direction(foot.point, vertex);
        if (normal && is_scene_edge(i, foot.point, *normal, near_side) &&
            is_tool_vertex(k, *normal))
            add(foot.point, vertex, {});
    }
    void try_scene_vertex(std::size_t i, std::size_t k) noexcept
    {
        const Vec3& vertex = on_scene_.vertices[i];
        const SegmentPoint foot = closest_point(side_of(on_tool_, k), vertex);
        if (!(foot.t > 0 && foot.t < 1)) return;
        const auto normal = direction(vertex, foot.point);
        if (normal && is_scene_vertex(i, *normal) &&
            is_tool_edge(k, foot.point, *normal, near_side))
            add(vertex, foot.point, {.turns = true});
    }
    void try_vertices(std::size_t i, std::size_t k) noexcept
    {
        const auto normal = direction(on_scene_.vertices[i], on_tool_.vertices[k]);
        if (normal && is_scene_vertex(i, *normal) && is_tool_vertex(k, *normal))
            add(on_scene_.vertices[i], on_tool_.vertices[k], {});
    }

    [[nodiscard]] bool is_scene_edge(std::size_t i, const Vec3& point, const Vec3& normal,
                                     double sine) const noexcept
    {
        return is_nearest(scene_, scene_.features->around_edge(scene_row_.edges[i]), point, normal,
                          sine);
    }
    [[nodiscard]] bool is_tool_edge(std::size_t k, const Vec3& point, const Vec3& normal,
                                    double sine) const noexcept
    {
        return is_nearest(tool_, tool_.features->around_edge(tool_row_.edges[k]), point, -normal,
                          sine);
    }
    [[nodiscard]] bool is_scene_vertex(std::size_t i, const Vec3& normal) const noexcept
    {
        return is_nearest(scene_, scene_.features->around_vertex(scene_row_.vertices[i]),
                          on_scene_.vertices[i], normal, near_side);
    }
    [[nodiscard]] bool is_tool_vertex(std::size_t k, const Vec3& normal) const noexcept
    {
        return is_nearest(tool_, tool_.features->around_vertex(tool_row_.vertices[k]),
                          on_tool_.vertices[k], -normal, near_side);
    }

    const PlacedFeatures& scene_;
    const PlacedFeatures& tool_;
    const FeatureRow& scene_row_;
    const FeatureRow& tool_row_;
    Triangle on_scene_;
    Triangle on_tool_;
    double farthest_;
    std::span<FeatureContact> contacts_;
    std::size_t count_ = 0;
};

} // namespace

double FeatureContact::gap_after(const Mat3& turn, const Vec3& moved_point) const noexcept
{
    const Vec3 across = moved_point - scene_point;
    if (turns) return (turn * normal).dot(across);
    const Vec3 crossing = scene_edge.cross(turn * tool_edge);
    const double length = crossing.norm();
    if (!(length > parallel)) return normal.dot(across);
    const double height = crossing.dot(across) / length;
    return crossing.dot(normal) < 0 ? -height : height;
}

std::size_t find_contacts(const NearPair& pair, const PlacedFeatures& scene,
                          const PlacedFeatures& tool, double farthest,
                          std::span<FeatureContact> contacts) noexcept
{
    return ContactFinder(pair, scene, tool, farthest, contacts).find();
}

} // namespace proxima
