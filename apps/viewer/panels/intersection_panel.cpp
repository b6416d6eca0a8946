// Two meshes, one of them moved: leaves that meet, their triangles, and the contour: figure 5.4.
#include "base/progress.h"
#include "proxima/execution.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "viewer/panels/panels.h"
#include "viewer/panels/placed_point.h"
#include "viewer/panels/shared_octree.h"
#include "viewer/query_shapes.h"

#include <fmt/core.h>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace proxima {
namespace {

constexpr unsigned a_color = 0xEBD9D5;
constexpr unsigned b_color = 0xD6E6D6;
constexpr unsigned leaf_of_a_color = 0xC62828;
constexpr unsigned leaf_of_b_color = 0x2E7D32;
constexpr unsigned part_color = 0xF2C81E;
constexpr unsigned contour_color = 0x102A6B;
constexpr unsigned path_color = 0xD32F2F;

struct IntersectionSettings {
    int depth = 5;
    int threshold = 8;
    double turn = 25.0; ///< degrees about the axis up
    double tilt = 30.0; ///< degrees about an axis across
    bool leaves = true;
    bool contour = true;
    PlacedPoint position; ///< of B's centre
};

Mat3 rotation_of(const IntersectionSettings& settings, const ViewModel& b)
{
    constexpr double degree = std::numbers::pi / 180.0;
    const Eigen::AngleAxisd turn(settings.turn * degree, b.up);
    const Eigen::AngleAxisd tilt(settings.tilt * degree, b.up.unitOrthogonal());
    return (turn * tilt).toRotationMatrix();
}

RigidTransform pose_of(const IntersectionSettings& settings, const ViewModel& b)
{
    RigidTransform pose;
    pose.rotation = rotation_of(settings, b);
    pose.translation = settings.position.at - pose.rotation * b.box.center();
    return pose;
}

/// The first one again where there is no other.
const std::shared_ptr<const ViewModel>& second_of(const ViewModels& models)
{
    return models.size() > 1 ? models[1] : models.front();
}

/// Where B's centre is at first: askew beside A's, so that they meet; of two of very different
/// sizes the small one's is on the surface of the large one.
Vec3 first_position(const IntersectionSettings& settings, const ViewModel& a, const ViewModel& b,
                    const Vec3& to_eye)
{
    constexpr double much = 2.0;
    const double size_of_a = a.box.extent().norm();
    const double size_of_b = b.box.extent().norm();
    if (size_of_a > much * size_of_b) return visible_point(a, to_eye, 0.02).point;
    if (size_of_b > much * size_of_a) {
        const Vec3 from_center = visible_point(b, to_eye, 0.02).point - b.box.center();
        return a.box.center() - rotation_of(settings, b) * from_center;
    }
    return point_at_offset(a, 0.243, -0.144, 0.087);
}

/// How far apart two meshes are that do not meet, and whether one is inside of the other.
class Separation {
public:
    [[nodiscard]] Status add(PanelPicture& picture, const ViewModel& a, const ViewModel& b,
                             const RigidTransform& pose, const Execution& context)
    {
        const auto sides = sides_.get(0, [&]() -> Result<Sides> {
            auto near_a = with_slabs(a.rays, {.execution = context});
            if (!near_a) return tl::unexpected(near_a.error());
            auto near_b = with_slabs(b.rays, {.execution = context});
            if (!near_b) return tl::unexpected(near_b.error());
            auto round_a = build_enclosure(a.rays, {.execution = context});
            if (!round_a) return tl::unexpected(round_a.error());
            auto round_b = build_enclosure(b.rays, {.execution = context});
            if (!round_b) return tl::unexpected(round_b.error());
            return Sides{*near_a, *near_b, *round_a, *round_b};
        });
        if (!sides) return tl::unexpected(sides.error());
        const Sides& of = **sides;
        const auto apart =
            mesh_distance(of.near_a, of.near_b, pose, {.progress = context.progress});
        if (is_cancelled(context.progress)) return cancelled("finding the distance");
        if (apart) picture.facts.push_back({"apart", fmt::format("{:.5g}", apart->distance)});
        switch (find_containment(of.round_a, of.round_b, pose).containment) {
        case Containment::none:
            break;
        case Containment::a_in_b:
            picture.facts.push_back({"inside", "A is inside of B"});
            break;
        case Containment::b_in_a:
            picture.facts.push_back({"inside", "B is inside of A"});
            break;
        }
        if (!apart) return {};
        auto scene = std::make_shared<DrawnScene>();
        scene->lines.push_back(
            {"shortest path", {{apart->point_a, apart->point_b}}, srgb(path_color), 3.0});
        picture.layers.push_back({std::move(scene)});
        picture.legend.entries.push_back({path_color, "shortest path"});
        return {};
    }

private:
    struct Sides {
        MeshIndex near_a, near_b;
        Enclosure round_a, round_b;
    };
    Kept<int, Sides> sides_;
};

SceneLines contour_lines(const IntersectionContour& contour)
{
    SceneLines lines{"contour", {}, srgb(contour_color), 4.0};
    for (const ContourLine& line : contour.lines) {
        const auto along = contour.points_of(line);
        for (std::size_t i = line.closed ? 0 : 1; i < along.size(); ++i) {
            const Vec3& before = along[(i + along.size() - 1) % along.size()].position;
            lines.segments.push_back({before, along[i].position});
        }
    }
    return lines;
}

/// The second one where it stands.
Box box_of_both(const ViewModel& a, const ViewModel& b, const RigidTransform& pose)
{
    Box all = a.box;
    for (const Vec3& position : b.mesh.positions()) all.extend(pose(position));
    return all;
}

/// Where they meet, with some of what is round it; none where they do not.
std::optional<Box> box_of_contact(const IntersectionContour& contour, const Box& both)
{
    Box contact;
    for (const ContourPoint& point : contour.points) contact.extend(point.position);
    if (contact.empty()) return std::nullopt;
    // A point alone is not enough to see.
    constexpr double least = 0.02; // per diagonal of both
    const Vec3 more = Vec3::Constant(least * both.extent().norm());
    return Box{contact.lower - more, contact.upper + more};
}

class IntersectionPanel final : public Panel {
public:
    [[nodiscard]] std::string_view name() const override { return "intersection"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "The first model and the second, or the first again, moved: leaves of their octrees "
               "that meet, red and green, the triangles in them yellow, and the contour; where "
               "they "
               "do not meet, the shortest path between them in red. Drag the ring to move the "
               "second.";
    }

    void models_changed(const ViewModels& models, const Vec3& to_eye) override
    {
        models_ = models;
        kept_a_ = std::make_shared<KeptOctree>();
        kept_b_ = std::make_shared<KeptOctree>();
        separation_ = std::make_shared<Separation>();
        settings_.position.place(
            first_position(settings_, *models.front(), *second_of(models), to_eye));
    }

    void offer(Controls& controls) override
    {
        controls.number("depth", settings_.depth, 0, 10);
        controls.number("threshold", settings_.threshold, 1, 1000);
        settings_.position.offer(controls, "position", models_);
        controls.number("turn", settings_.turn, -180.0, 180.0);
        controls.number("tilt", settings_.tilt, -180.0, 180.0);
        controls.toggle("leaves", settings_.leaves);
        controls.toggle("contour", settings_.contour);
    }

    [[nodiscard]] Box extent(const ViewModels& models) const override
    {
        if (models.empty()) return {};
        const ViewModel& b = *second_of(models);
        return box_of_both(*models.front(), b, pose_of(settings_, b));
    }

    [[nodiscard]] std::vector<Vec3> handles() const override { return {settings_.position.at}; }
    void move_handle(std::size_t /*handle*/, const Vec3& to) override
    {
        settings_.position.set(to);
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [a = models.front(), b = second_of(models), settings = settings_, kept_a = kept_a_,
                kept_b = kept_b_,
                separation = separation_](const Execution& context) -> Result<PanelPicture> {
            const OctreeChoice choice = {1, settings.depth, settings.threshold};
            const auto octree_a = octree_of(*kept_a, choice, *a, context);
            if (!octree_a) return tl::unexpected(octree_a.error());
            const auto octree_b = octree_of(*kept_b, choice, *b, context);
            if (!octree_b) return tl::unexpected(octree_b.error());
            const RigidTransform pose = pose_of(settings, *b);
            std::vector<LeafPair> leaves;
            visit_intersecting_leaves(**octree_a, **octree_b, pose, [&](const LeafPair& pair) {
                leaves.push_back(pair);
                return is_cancelled(context.progress) ? Flow::stop : Flow::proceed;
            });
            if (is_cancelled(context.progress)) return cancelled("finding leaves that meet");
            const auto candidates =
                candidate_triangles(**octree_a, **octree_b, leaves, context.progress);
            if (!candidates) return tl::unexpected(candidates.error());
            const auto found =
                intersecting_pairs(a->rays, b->rays, std::span(&pose, 1), {.execution = context});
            if (!found) return tl::unexpected(found.error());
            const std::vector<TrianglePair>& pairs = found->pairs;
            const auto on_both =
                intersection_contour(a->mesh, b->mesh, pose, pairs, {.execution = context});
            if (!on_both) return tl::unexpected(on_both.error());
            const IntersectionContour& contour = *on_both;

            PanelPicture picture;
            picture.focus = box_of_contact(contour, box_of_both(*a, *b, pose));
            picture.layers = {{.scene = a->flat, .color = srgb(a_color)},
                              {.scene = b->flat, .pose = pose, .color = srgb(b_color)}};
            auto of_a = std::make_shared<DrawnScene>();
            auto of_b = std::make_shared<DrawnScene>();
            const ShapeStyle yellow = {
                .name = "triangles in leaves that meet", .color = srgb(part_color), .lift = 2e-4};
            add_part(*of_a, a->mesh, candidates->a, yellow);
            add_part(*of_b, b->mesh, candidates->b, yellow);
            const auto boxes_a = boxes_of_leaves(**octree_a, leaves, &LeafPair::a);
            const auto boxes_b = boxes_of_leaves(**octree_b, leaves, &LeafPair::b);
            if (settings.leaves) {
                add_box_edges(
                    *of_a, boxes_a,
                    {.name = "leaves of A", .color = srgb(leaf_of_a_color), .width = 1.3});
                add_box_edges(
                    *of_b, boxes_b,
                    {.name = "leaves of B", .color = srgb(leaf_of_b_color), .width = 1.3});
            }
            if (settings.contour) of_a->lines.push_back(contour_lines(contour));
            picture.layers.push_back({std::move(of_a)});
            picture.layers.push_back({.scene = std::move(of_b), .pose = pose});
            auto& legend = picture.legend.entries;
            legend = {{a_color, "A"}, {b_color, "B"}};
            if (settings.leaves && !leaves.empty()) {
                legend.push_back({leaf_of_a_color, "leaves of A that meet B's"});
                legend.push_back({leaf_of_b_color, "leaves of B that meet A's"});
            }
            if (!leaves.empty()) legend.push_back({part_color, "triangles in them"});
            if (settings.contour && !pairs.empty()) legend.push_back({contour_color, "contour"});
            std::size_t closed = 0;
            for (const ContourLine& line : contour.lines) closed += line.closed ? 1 : 0;
            picture.facts = {
                {"meet", pairs.empty() ? "no" : "yes"},
                {"pairs of triangles", fmt::format("{}", pairs.size())},
                {"pairs of leaves", fmt::format("{}", leaves.size())},
                {"leaves", fmt::format("{} of A, {} of B", boxes_a.size(), boxes_b.size())},
                {"triangles in them",
                 fmt::format("{} of A, {} of B", candidates->a.size(), candidates->b.size())},
                {"contour", fmt::format("{} lines, {} closed, {:.5g} long", contour.lines.size(),
                                        closed, contour.length())}};
            if (pairs.empty()) {
                if (Status status = separation->add(picture, *a, *b, pose, context); !status)
                    return tl::unexpected(status.error());
            }
            return picture;
        };
    }

private:
    IntersectionSettings settings_;
    ViewModels models_;
    std::shared_ptr<KeptOctree> kept_a_ = std::make_shared<KeptOctree>();
    std::shared_ptr<KeptOctree> kept_b_ = std::make_shared<KeptOctree>();
    std::shared_ptr<Separation> separation_ = std::make_shared<Separation>();
};

} // namespace

std::unique_ptr<Panel> make_intersection_panel()
{
    return std::make_unique<IntersectionPanel>();
}

} // namespace proxima
