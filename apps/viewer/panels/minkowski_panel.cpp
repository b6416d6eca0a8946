// The Minkowski sum of two convex bodies: facets by where they come from, and B growing from
// nothing, which pushes the planes of A outward: chapter 3.
#include "cli/camera_options.h"
#include "proxima/convex_polyhedron.h"
#include "proxima/execution.h"
#include "proxima/sample_meshes.h"
#include "viewer/figures/scene_figure.h"
#include "viewer/panels/panels.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>

namespace proxima {
namespace {

enum class Body : std::uint8_t { cube, octahedron, triangle, ball, model };
constexpr std::array<std::string_view, 5> body_names = {"cube", "octahedron", "triangle", "ball",
                                                        "model"};

struct SumChoice {
    Body a = Body::cube;
    Body b = Body::octahedron;
    friend bool operator==(const SumChoice&, const SumChoice&) = default;
};

struct SumSettings {
    SumChoice bodies;
    double size = 0.55;  ///< of B
    double pushed = 1.0; ///< how much of B's size
    bool playing = false;
    bool copies = true;
    bool normals = false;
    bool body = false; ///< A itself
};

/// About 1 in size, whatever the model's.
Result<ConvexPolyhedron> make_body(Body body, const ViewModel& model, Progress* progress)
{
    switch (body) {
    case Body::cube:
        return polyhedron_of_mesh(make_cube());
    case Body::octahedron:
        return polyhedron_of_mesh(make_octahedron());
    case Body::triangle:
        return polyhedron_of_triangle(
            {{Vec3(-1, -0.35, -0.4), Vec3(1, -0.45, -0.15), Vec3(0.1, 0.65, 0.8)}});
    case Body::ball:
        return polyhedron_of_mesh(make_icosphere(1));
    case Body::model:
        break;
    }
    // Exactly convex in other coordinates may be a little concave after rounding: its hull.
    if (const auto convex = polyhedron_of_mesh(model.mesh, {.execution = {.progress = progress}});
        !convex) {
        return fail(convex.error().code,
                    convex.error().message + ": choose a convex body instead of the model",
                    model.name);
    }
    std::vector<Vec3> points = points_to_frame(model.mesh); // of triangles: what they bound
    Box box;
    for (const Vec3& point : points) box.extend(point);
    const Vec3 center = box.center();
    const double scale = 2.0 / std::max(box.extent().maxCoeff(), 1e-300);
    for (Vec3& point : points) point = scale * (point - center);
    return convex_hull(points, {}, {.progress = progress});
}

Result<MinkowskiSum> make_sum(const SumChoice& bodies, const ViewModel& model,
                              const Execution& context)
{
    const auto a = make_body(bodies.a, model, context.progress);
    if (!a) return tl::unexpected(a.error());
    const auto b = make_body(bodies.b, model, context.progress);
    if (!b) return tl::unexpected(b.error());
    return minkowski_sum(*a, *b, {.execution = {.progress = context.progress}});
}

const EdgeStyle sum_edges = {.name = "edges", .color = srgb(0x333333), .width = 1.6};

Result<std::shared_ptr<const DrawnScene>> facets_scene(const MinkowskiSum& sum,
                                                       const SumSettings& settings)
{
    const auto surface = draw(sum);
    if (!surface) return tl::unexpected(surface.error());
    auto scene = std::make_shared<DrawnScene>();
    for (const auto& [origin, name] : {std::pair{FacetOrigin::a, "facets of A"},
                                       {FacetOrigin::b, "facets of B"},
                                       {FacetOrigin::both, "facets of both"},
                                       {FacetOrigin::swept, "swept facets"}}) {
        const auto facets = facets_of(sum, origin);
        if (facets.empty()) continue;
        add_polygons(*scene, *surface, facets, {.name = name, .color = color_of(origin)});
        add_polygon_edges(*scene, *surface, facets, sum_edges);
        if (settings.normals) {
            add_normals(*scene, sum, *surface, facets, 0.45,
                        {.name = "normal", .color = color_of(origin)});
        }
    }
    return std::shared_ptr<const DrawnScene>(std::move(scene));
}

class MinkowskiPanel final : public Panel {
public:
    [[nodiscard]] std::string_view name() const override { return "minkowski"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "The sum of two convex bodies: facets of A red, of B blue, of both violet, swept "
               "by an edge along an edge green. Play pushes the planes out from A to the sum.";
    }

    void models_changed(const ViewModels& /*models*/, const Vec3& /*to_eye*/) override
    {
        kept_ = std::make_shared<Kept<SumChoice, MinkowskiSum>>();
    }

    void offer(Controls& controls) override
    {
        choose(controls, "A", settings_.bodies.a, body_names);
        choose(controls, "B", settings_.bodies.b, body_names);
        controls.number("size of B", settings_.size, 0.05, 2.0);
        controls.number("pushed", settings_.pushed, 0.0, 1.0);
        controls.toggle("play", settings_.playing);
        controls.toggle("copies of B", settings_.copies);
        controls.toggle("normals", settings_.normals);
        controls.toggle("A itself", settings_.body);
    }

    [[nodiscard]] Box extent(const ViewModels& /*models*/) const override
    {
        // Bodies are about as large as the cube from -1 to 1, and B is as large as it is set.
        const double half = 1.0 + settings_.size;
        return {Vec3::Constant(-half), Vec3::Constant(half)};
    }

    bool advance(double seconds) override
    {
        if (!settings_.playing || seconds <= 0.0) return false;
        constexpr double duration = 4.0;
        settings_.pushed += std::min(seconds, 0.1) / duration;
        if (settings_.pushed > 1.0) settings_.pushed = 0.0;
        return true;
    }
    [[nodiscard]] bool is_moving() const override { return settings_.playing; }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [model = models.front(), settings = settings_,
                kept = kept_](const Execution& context) -> Result<PanelPicture> {
            const auto made = kept->get(settings.bodies,
                                        [&] { return make_sum(settings.bodies, *model, context); });
            if (!made) return tl::unexpected(made.error());
            constexpr double least = 1e-3; // nothing of B at all is A, whose facets are fewer
            const MinkowskiSum sum =
                (*made)->scaled(std::max(settings.pushed, least) * settings.size);
            auto facets = facets_scene(sum, settings);
            if (!facets) return tl::unexpected(facets.error());
            PanelPicture picture;
            picture.layers.push_back({std::move(*facets)});
            if (settings.copies) {
                auto copies = copies_scene(sum);
                if (!copies) return tl::unexpected(copies.error());
                picture.layers.push_back({std::move(*copies)});
                picture.layers.front().opacity = 0.55F;
            }
            if (settings.body) {
                auto scene = std::make_shared<DrawnScene>();
                if (Status status =
                        add_polyhedron(*scene, sum.a(), Vec3::Zero(),
                                       {.name = "A", .color = srgb(0xE9E1D2)}, sum_edges);
                    !status) {
                    return tl::unexpected(status.error());
                }
                picture.layers.push_back({std::move(scene)});
                picture.layers.front().opacity = 0.55F;
            }
            for (const auto& [origin, words] : {std::pair{FacetOrigin::a, "facets of A"},
                                                std::pair{FacetOrigin::b, "facets of B"},
                                                std::pair{FacetOrigin::both, "facets of both"},
                                                std::pair{FacetOrigin::swept, "swept facets"}}) {
                if (!facets_of(sum, origin).empty())
                    picture.legend.entries.push_back({hex_of(color_of(origin)), words});
            }
            const auto count = [&](FacetOrigin origin) {
                return fmt::format("{}", facets_of(sum, origin).size());
            };
            picture.facts = {
                {"facets", fmt::format("{}", sum.facet_count())},
                {"of A", count(FacetOrigin::a)},
                {"of B", count(FacetOrigin::b)},
                {"of both", count(FacetOrigin::both)},
                {"swept", count(FacetOrigin::swept)},
                {"corners", fmt::format("{} of {} x {} points", sum.point_count(),
                                        sum.a().points().size(), sum.b().points().size())},
                {"edges", fmt::format("{}", sum.edges().size())}};
            return picture;
        };
    }

private:
    /// B at every corner of A, as large as it is pushed.
    static Result<std::shared_ptr<const DrawnScene>> copies_scene(const MinkowskiSum& sum)
    {
        constexpr std::size_t most = 60;
        auto scene = std::make_shared<DrawnScene>();
        auto body = draw(sum.b());
        if (!body) return tl::unexpected(body.error());
        for (Vec3& position : body->positions) position *= sum.scale();
        const auto all = first_numbers(body->polygon_count());
        std::size_t shown = 0;
        for (const Vec3& corner : sum.a().points()) {
            if (++shown > most) break;
            DrawnSurface copy = *body;
            for (Vec3& position : copy.positions) position += corner;
            add_polygons(*scene, copy, all,
                         {.name = "copy of B", .color = color_of(FacetOrigin::b)});
            add_polygon_edges(*scene, copy, all, sum_edges);
        }
        return std::shared_ptr<const DrawnScene>(std::move(scene));
    }

    SumSettings settings_;
    std::shared_ptr<Kept<SumChoice, MinkowskiSum>> kept_ =
        std::make_shared<Kept<SumChoice, MinkowskiSum>>();
};

} // namespace

std::unique_ptr<Panel> make_minkowski_panel()
{
    return std::make_unique<MinkowskiPanel>();
}

} // namespace proxima
