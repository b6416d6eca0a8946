// Voronoi regions of a model's features, and the proximity octree that stores them: chapter 4.
#include "base/progress.h"
#include "index/index_parts.h"
#include "index/lists/proximity_lists.h"
#include "proxima/cast_ray.h"
#include "proxima/execution.h"
#include "thesis/proximity_octree/list_statistics.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/panels/panels.h"
#include "viewer/panels/placed_point.h"
#include "viewer/panels/region_shape.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <fmt/core.h>
#include <optional>

namespace proxima {
namespace {

constexpr double cursor_height = 0.04; // above the surface, per diagonal

constexpr unsigned listed_color = 0xF2A65A;

struct VoronoiSettings {
    int model = 1;
    FeatureKind kind = FeatureKind::vertex;
    int number = 0;
    bool is_set = false;     ///< by a person
    double length = 0.5;     ///< of the region, per diagonal, at most
    bool has_length = false; ///< by a person
    bool region = true;
    bool leaf = true;
    PlacedPoint cursor;
};

std::size_t count_of(const ViewModel& model, FeatureKind kind)
{
    return kind == FeatureKind::vertex ? model.mesh.vertex_count()
           : kind == FeatureKind::edge ? model.topology.edge_count()
                                       : model.mesh.triangle_count();
}

Color color_of_kind(FeatureKind kind)
{
    return kind == FeatureKind::vertex ? srgb(0x4A7FD0)
           : kind == FeatureKind::edge ? srgb(0x57B57A)
                                       : srgb(0xEBC23B);
}

/// How many leaves list how many triangles; the few longest lists, which would leave no space for
/// the others, are left out.
PanelPlot list_plot(const ProximityLists& built)
{
    constexpr double share = 0.999;
    const LeafLists lists = list_lengths(built);
    const ListStatistics statistics = list_statistics(lists.lengths);
    std::uint32_t longest = 0;
    while (longest < statistics.max && statistics.share_up_to(longest) < share) ++longest;
    PanelPlot plot = {fmt::format("leaves that list 0, 1, ... {} triangles", longest), {}, true};
    for (std::size_t length = 0; length < statistics.weights.size() && length <= longest; ++length)
        plot.values.push_back(static_cast<float>(statistics.weights[length]));
    return plot;
}

constexpr float glass = 0.3F; ///< the model's opacity where its region lies behind the surface

/// Error cancelled.
Status show_region(PanelPicture& picture, const ViewModel& model, const MeshIndex& with,
                   const VoronoiSettings& settings, Feature feature, const Progress* progress)
{
    auto scene = std::make_shared<DrawnScene>();
    add_feature(*scene, model, feature, mark_radius(model), srgb(figure_colors::red));
    picture.legend.entries.push_back({figure_colors::red, "feature"});
    if (settings.region) {
        const double length = settings.length * model.box.extent().norm();
        const auto region = region_shape(model, with, feature, length, progress);
        if (is_cancelled(progress)) return cancelled("finding the region");
        if (region) {
            add_region(*scene, *region, color_of_kind(feature.kind));
            if (region->shape != ConeShape::empty) {
                picture.legend.entries.push_back(
                    {hex_of(color_of_kind(feature.kind)), "its Voronoi region"});
            }
            picture.facts.push_back({"region", words_for_region(*region)});
            if (region->shape != ConeShape::empty)
                picture.facts.push_back({"its end", words_for_end(*region)});
            // What lies behind the surface is seen through it.
            if (region->side == ConeSide::behind)
                picture.layers[static_cast<std::size_t>(settings.model - 1)].opacity = glass;
        } else {
            picture.facts.push_back({"region", "none: " + region.error().message});
        }
    }
    picture.layers.push_back({std::move(scene)});
    return {};
}

void show_leaf(PanelPicture& picture, const ViewModel& model, const MeshIndex& with,
               const Vec3& cursor)
{
    const auto leaf = leaf_at(with, cursor);
    auto scene = std::make_shared<DrawnScene>();
    add_cursor(*scene, model, cursor);
    if (leaf) {
        add_part(*scene, model.mesh, leaf->listed,
                 {.name = "listed", .color = srgb(listed_color), .lift = 4e-4});
        add_leaf(*scene, *leaf);
        picture.legend.entries.push_back({figure_colors::green, "leaf of the cursor"});
        picture.legend.entries.push_back({listed_color, "triangles that it lists"});
    }
    picture.facts.push_back(
        {"leaf under the cursor",
         leaf ? fmt::format("depth {}, {} triangles", leaf->depth, leaf->listed.size())
              : "outside of the root"});
    picture.layers.push_back({std::move(scene)});
}

Vec3 middle_of(const ViewModel& model, const Feature& feature)
{
    switch (feature.kind) {
    case FeatureKind::vertex:
        return model.mesh.position(VertexId{feature.id});
    case FeatureKind::edge: {
        const auto [a, b] = model.topology.vertices(EdgeId{feature.id});
        return 0.5 * (model.mesh.position(a) + model.mesh.position(b));
    }
    case FeatureKind::face:
        break;
    }
    const Triangle triangle = model.mesh.triangle(TriangleId{feature.id});
    return (triangle[0] + triangle[1] + triangle[2]) / 3.0;
}

/// \pre there is one
Feature feature_of(const VoronoiSettings& settings)
{
    return {settings.kind, static_cast<std::uint32_t>(settings.number)};
}

/// A feature, and a point that is nearest to it: within its region.
struct FeatureWithPoint {
    std::uint32_t id = 0;
    std::optional<Vec3> above; ///< none where it has no region outside
};

/// The feature of a kind nearest to a point among those that an eye in the direction `to_eye` sees
/// and that have a region outside, of so many that are near; the nearest of all where none has one.
FeatureWithPoint feature_with_region(const ViewModel& model, FeatureKind kind, const Vec3& point,
                                     const Vec3& to_eye)
{
    constexpr std::size_t tried = 5000;
    std::vector<std::pair<double, std::uint32_t>> near;
    near.reserve(count_of(model, kind));
    for (std::uint32_t id = 0; id < count_of(model, kind); ++id)
        near.emplace_back((middle_of(model, {kind, id}) - point).squaredNorm(), id);
    const auto some = static_cast<std::ptrdiff_t>(std::min(near.size(), tried));
    std::ranges::partial_sort(near, near.begin() + some);
    for (std::ptrdiff_t i = 0; i < some; ++i) {
        const std::uint32_t id = near[static_cast<std::size_t>(i)].second;
        const auto cone = local_cone(model.mesh, model.topology, {kind, id});
        if (!cone || cone->shape != ConeShape::solid || cone->side != ConeSide::outside) continue;
        Vec3 outward = Vec3::Zero();
        for (const ConeCorner& corner : cone->corners) outward += corner.direction;
        const Vec3 above = middle_of(model, {kind, id}) +
                           cursor_height * model.box.extent().norm() * outward.stableNormalized();
        if (outward.dot(to_eye) > 0.0 &&
            !any_hit(model.rays, {.origin = above, .direction = to_eye}))
            return {id, above};
    }
    return {near.empty() ? 0 : near.front().second, std::nullopt};
}

class VoronoiPanel final : public Panel {
public:
    explicit VoronoiPanel(std::shared_ptr<SharedProximity> proximity)
        : proximity_(std::move(proximity))
    {}

    [[nodiscard]] std::string_view name() const override { return "voronoi"; }
    [[nodiscard]] std::string_view purpose() const override
    {
        return "The Voronoi region of a feature, up to where another one is as near; it fades "
               "where it goes on: click near a corner, near a side or on a face. Where the surface "
               "bends inward it lies behind that, which turns to glass. "
               "The leaf of the proximity octree under the cursor, with the triangles that it "
               "lists in orange; drag the ring.";
    }

    void models_changed(const ViewModels& models, const Vec3& to_eye) override
    {
        models_ = models;
        settings_.model = std::clamp(settings_.model, 1, static_cast<int>(models.size()));
        to_eye_ = to_eye;
        begin_with_model();
        // At first all of the region is in the picture.
        if (!settings_.has_length)
            settings_.length = 0.5 * focus(models).extent().norm() / model()->box.extent().norm();
    }

    void offer(Controls& controls) override
    {
        const int before = settings_.model;
        offer_model(controls, settings_.model, models_.size());
        if (settings_.model != before && !models_.empty()) begin_with_model();
        if (choose(controls, "feature", settings_.kind,
                   std::array<std::string_view, 3>{"vertex", "edge", "face"})) {
            settings_.is_set = false;
            settings_.number = models_.empty()
                                   ? 0
                                   : std::min(static_cast<int>(likely_feature().id), most_number());
        }
        if (most_number() >= 0 && controls.number("number", settings_.number, 0, most_number()))
            settings_.is_set = true;
        controls.toggle("region", settings_.region);
        if (controls.number("length", settings_.length, 0.01, 2.0)) settings_.has_length = true;
        controls.toggle("leaf", settings_.leaf);
        settings_.cursor.offer(controls, "cursor", models_);
    }

    [[nodiscard]] std::vector<Vec3> handles() const override { return {settings_.cursor.at}; }
    void move_handle(std::size_t /*handle*/, const Vec3& to) override { settings_.cursor.set(to); }

    bool picked(const PickedPoint& hit) override
    {
        settings_.model = static_cast<int>(hit.model) + 1;
        settings_.kind = hit.nearest.kind;
        settings_.number = static_cast<int>(hit.nearest.id);
        settings_.is_set = true;
        return true;
    }

    [[nodiscard]] Box focus(const ViewModels& models) const override
    {
        if (models.empty()) return {};
        const bool is_chosen = settings_.is_set && settings_.number >= 0;
        return close_up(
            *model(), is_chosen ? middle_of(*model(), feature_of(settings_)) : settings_.cursor.at,
            0.05);
    }

    [[nodiscard]] PanelTask task(const ViewModels& models) const override
    {
        return [models, model = model(), settings = settings_,
                proximity = proximity_](const Execution& context) -> Result<PanelPicture> {
            const auto with = proximity_of(*proximity, model, context);
            if (!with) return tl::unexpected(with.error());
            if (settings.number < 0) {
                return fail(ErrorCode::invalid_argument,
                            "the model has no features of this kind: choose another one",
                            "feature");
            }
            const Feature feature = feature_of(settings);
            PanelPicture picture;
            picture.layers = model_layers(models, Smoothing::flat);
            picture.facts.push_back({"feature", words_for(feature)});
            if (Status status =
                    show_region(picture, *model, **with, settings, feature, context.progress);
                !status)
                return tl::unexpected(status.error());
            if (settings.leaf) show_leaf(picture, *model, **with, settings.cursor.at);
            const ProximityStatistics& s = (*with)->parts().lists()->statistics();
            picture.facts.push_back({"leaves", fmt::format("{}", s.leaves)});
            picture.facts.push_back({"deepest", fmt::format("{}", s.max_depth)});
            picture.facts.push_back({"mean list", fmt::format("{:.2f}", s.mean_list)});
            picture.facts.push_back({"longest list", fmt::format("{}", s.max_list)});
            picture.facts.push_back(
                {"memory",
                 fmt::format("{:.2f} MB",
                             1e-6 * static_cast<double>((*with)->parts().lists()->bytes()))});
            picture.plots.push_back(list_plot(*(*with)->parts().lists()));
            return picture;
        };
    }

private:
    [[nodiscard]] const std::shared_ptr<const ViewModel>& model() const
    {
        return models_[static_cast<std::size_t>(settings_.model - 1)];
    }
    /// Puts the cursor and the feature where the model has them; those that a person has set stay,
    /// a feature as far as the model has one of its number. \pre there are models
    void begin_with_model()
    {
        settings_.cursor.place(visible_point(*model(), to_eye_, cursor_height)
                                   .above(cursor_height * model()->box.extent().norm()));
        if (settings_.is_set) {
            settings_.number = std::min(settings_.number, most_number());
            return;
        }
        const FeatureWithPoint likely = likely_feature();
        settings_.number = std::min(static_cast<int>(likely.id), most_number());
        if (likely.above) settings_.cursor.place(*likely.above);
    }
    /// The feature where nobody has chosen one. \pre there are models
    [[nodiscard]] FeatureWithPoint likely_feature() const
    {
        return feature_with_region(*model(), settings_.kind, settings_.cursor.at, to_eye_);
    }
    /// Before there are models any number will do.
    [[nodiscard]] int most_number() const
    {
        constexpr std::size_t most = 1U << 30U;
        const std::size_t count = models_.empty() ? most : count_of(*model(), settings_.kind);
        return static_cast<int>(std::min(count, most)) - 1;
    }

    VoronoiSettings settings_;
    ViewModels models_;
    Vec3 to_eye_ = Vec3::UnitZ();
    std::shared_ptr<SharedProximity> proximity_;
};

} // namespace

std::unique_ptr<Panel> make_voronoi_panel(std::shared_ptr<SharedProximity> proximity)
{
    return std::make_unique<VoronoiPanel>(std::move(proximity));
}

} // namespace proxima
