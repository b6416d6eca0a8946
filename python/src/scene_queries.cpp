#include "arrays.h"
#include "index_methods.h"
#include "proxima/scene.h"
#include "rays.h"
#include "run.h"
#include "scene.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// What a point has in the columns of which nothing is within the radius.
const SceneFeature nothing{InstanceId{std::numeric_limits<std::uint32_t>::max()},
                           no_closest_feature(), Vec3::Constant(nan), infinity};

py::object closest_in_scene(const Scene& self, const py::object& points, double radius,
                            const py::object& layers, Integer threads, const py::object& progress)
{
    const PointsArgument argument(points, "points");
    check_not_negative(radius, "radius");
    SceneFeatureOptions options{.radius = radius,
                                .layers = layers_of(layers, "layers"),
                                .execution = {.threads = threads_of(threads)}};
    const std::size_t count = argument.size();
    std::vector<std::optional<SceneFeature>> found(count);
    auto instance = new_array<std::int32_t>(count);
    auto distance = new_array<double>(count);
    auto point = new_rows<double>(count, 3);
    auto triangle = new_array<std::int32_t>(count);
    auto kind = new_array<std::uint8_t>(count);
    auto feature = new_array<std::int32_t>(count);
    auto barycentric = new_rows<double>(count, 3);
    run(progress, duration_of(count), [&](Progress* watched) {
        options.execution.progress = watched;
        return closest_features(self, argument.points(), found, options);
    });
    for (std::size_t i = 0; i < count; ++i) {
        const SceneFeature& one = found[i] ? *found[i] : nothing;
        instance.mutable_data()[i] = static_cast<std::int32_t>(to_index(one.instance));
        distance.mutable_data()[i] = one.distance;
        elements_of<Vec3>(point)[i] = one.point;
        elements_of<TriangleId>(triangle)[i] = one.closest.triangle;
        kind.mutable_data()[i] = static_cast<std::uint8_t>(one.closest.feature.kind);
        feature.mutable_data()[i] = static_cast<std::int32_t>(one.closest.feature.id);
        elements_of<std::array<double, 3>>(barycentric)[i] = one.closest.barycentric;
    }
    return result_type("SceneClosest")(instance, distance, point, triangle, kind, feature,
                                       barycentric);
}

/// Columns of hits, the instance first.
class SceneHitArrays {
public:
    explicit SceneHitArrays(std::size_t size)
        : instance_(new_array<std::int32_t>(size)), to_instance_(instance_.mutable_data()),
          hits_(size)
    {}
    void set(std::size_t i, const SceneHit& hit) noexcept
    {
        to_instance_[i] = static_cast<std::int32_t>(to_index(hit.instance));
        hits_.set(i, hit.hit);
    }
    [[nodiscard]] const py::array& instance() const noexcept { return instance_; }
    [[nodiscard]] py::tuple columns() const { return hits_.columns(); }

private:
    py::array_t<std::int32_t> instance_;
    std::int32_t* to_instance_;
    HitArrays hits_;
};

py::object cast_rays_in_scene(const Scene& self, const py::object& origins,
                              const py::object& directions, const py::object& t_min,
                              const py::object& t_max, const std::string& hits,
                              const std::string& faces, const py::object& layers, Integer threads,
                              const py::object& progress)
{
    const std::vector<Ray> rays = rays_of(origins, directions, t_min, t_max);
    SceneRayOptions options{.faces = faces_named(faces),
                            .layers = layers_of(layers, "layers"),
                            .execution = {.threads = threads_of(threads)}};
    const Duration duration = duration_of(rays.size());
    if (hits == "any") {
        auto answers = new_array<bool>(rays.size());
        run(progress, duration, [&](Progress* watched) {
            options.execution.progress = watched;
            return any_hits(self, rays, elements_of<bool>(answers), options);
        });
        return answers;
    }
    if (hits == "first") {
        std::vector<std::optional<SceneHit>> found(rays.size());
        run(progress, duration, [&](Progress* watched) {
            options.execution.progress = watched;
            return closest_hits(self, rays, found, options);
        });
        SceneHitArrays arrays(rays.size());
        for (std::size_t i = 0; i < found.size(); ++i)
            arrays.set(i, found[i].value_or(SceneHit{nothing.instance, no_hit}));
        return result_type("SceneHits")(arrays.instance(), *arrays.columns());
    }
    if (hits == "all") {
        const SceneHitLists lists = run(progress, duration, [&](Progress* watched) {
            options.execution.progress = watched;
            return all_hits(self, rays, options);
        });
        SceneHitArrays arrays(lists.hits.size());
        for (std::size_t i = 0; i < lists.hits.size(); ++i) arrays.set(i, lists.hits[i]);
        return result_type("SceneHitLists")(
            array_of<std::int64_t>(std::span<const std::size_t>(lists.first)), arrays.instance(),
            *arrays.columns());
    }
    refuse("hits", R"(must be "first", "any" or "all", is ")" + hits + "\"");
}

struct VisibleTriangles {
    std::vector<InstanceId> instances; ///< one for each triangle
    std::vector<TriangleId> triangles; ///< those of each instance ascending
};

/// The triangles of ranges of rows.
Result<VisibleTriangles> triangles_in(const Scene& self, std::span<const InstanceRange> ranges,
                                      Progress* watched)
{
    std::size_t count = 0;
    for (const InstanceRange& range : ranges) count += range.rows.count;
    watched->begin_stage("visible triangles", count);
    VisibleTriangles visible;
    visible.instances.reserve(count);
    visible.triangles.reserve(count);
    for (std::size_t i = 0; i < ranges.size();) {
        if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
        const InstanceId id = ranges[i].instance;
        const auto ids = self.shape(self.instance(id).shape).ids();
        const std::size_t first = visible.triangles.size();
        for (; i < ranges.size() && ranges[i].instance == id; ++i) {
            const auto rows = ids.subspan(ranges[i].rows.first, ranges[i].rows.count);
            visible.triangles.insert(visible.triangles.end(), rows.begin(), rows.end());
        }
        std::ranges::sort(std::span(visible.triangles).subspan(first));
        visible.instances.resize(visible.triangles.size(), id);
        watched->advance(visible.triangles.size() - first);
    }
    return visible;
}

py::object visible_instances(const Scene& self, const py::object& planes, bool triangles,
                             bool exact, const py::object& layers, Integer threads,
                             const py::object& progress)
{
    const ViewVolume volume = volume_of(planes);
    SceneCullOptions options{.mode = exact ? CullMode::exact : CullMode::conservative,
                             .layers = layers_of(layers, "layers"),
                             .execution = {.threads = threads_of(threads)}};
    const auto watch = [&](Progress* watched) { options.execution.progress = watched; };
    if (!triangles) {
        return instances_of(run(progress, Duration::lengthy, [&](Progress* watched) {
            watch(watched);
            return visible_instances(self, volume, options);
        }));
    }
    const VisibleTriangles visible =
        run(progress, Duration::lengthy, [&](Progress* watched) -> Result<VisibleTriangles> {
            watch(watched);
            const auto ranges = visible_ranges(self, volume, options);
            if (!ranges) return tl::unexpected(ranges.error());
            return triangles_in(self, *ranges, watched);
        });
    return result_type("InstanceTriangles")(
        instances_of(visible.instances),
        array_of<std::int32_t>(std::span<const TriangleId>(visible.triangles)));
}

py::array instances_in_box(const Scene& self, const py::object& lower, const py::object& upper,
                           const py::object& layers)
{
    const Box box = box_between(lower, upper);
    if (!box.lower.allFinite() || !box.upper.allFinite())
        refuse("lower", "must be finite, as must upper");
    std::vector<InstanceId> ids;
    visit_instances(self, box, layers_of(layers, "layers"), [&](InstanceId id) {
        ids.push_back(id);
        return Flow::proceed;
    });
    std::ranges::sort(ids);
    return instances_of(ids);
}

} // namespace

void bind_scene_queries(py::class_<Scene>& scene)
{
    const py::int_ all(all_layers);
    scene
        .def("closest", &closest_in_scene, py::arg("points"), py::kw_only(),
             py::arg("radius") = infinity, py::arg("layers") = all, py::arg("threads") = 0,
             py::arg("progress") = py::none(),
             R"(The closest points of all instances to points (n, 3), as SceneClosest.

    radius  in the scene's unit: nothing farther is found
    layers  bits: only instances that have one of them

Equally near instances: the lowest. 3 to 6 us each among 10,000 instances. Raises InvalidInput for NaN and infinity.)")
        .def("cast", &cast_rays_in_scene, py::arg("origins"), py::arg("directions"), py::kw_only(),
             py::arg("t_min") = 0.0, py::arg("t_max") = infinity, py::arg("hits") = "first",
             py::arg("faces") = "both", py::arg("layers") = all, py::arg("threads") = 0,
             py::arg("progress") = py::none(),
             R"(What rays hit, with arguments as Index.cast() has them.

    hits    "first": SceneHits; "any": (n,) bool; "all": SceneHitLists
    layers  bits: only instances that have one of them

About 1 us each among 10,000 instances. Raises InvalidInput where a ray is not finite or its direction is zero.)")
        .def(
            "visible", &visible_instances, py::arg("planes"), py::kw_only(),
            py::arg("triangles") = false, py::arg("exact") = false, py::arg("layers") = all,
            py::arg("threads") = 0, py::arg("progress") = py::none(),
            R"(Instances of which a triangle is in a view volume, (m,) int32, ascending. Occlusion is not tested.

    planes     (k, 4) floats, as Index.visible() takes them
    triangles  True: all triangles in view, as InstanceTriangles
    exact      True: exactly those that have a point in common with the volume, else also some near its edges
    layers     bits: only instances that have one of them)")
        .def("in_box", &instances_in_box, py::arg("lower"), py::arg("upper"), py::kw_only(),
             py::arg("layers") = all,
             "The instances whose box, that of `bounds`, has a point in common with a box of "
             "corners (3,): (m,) int32, ascending.");
}

} // namespace proxima::python
