#include "arrays.h"
#include "proxima/scene.h"
#include "run.h"
#include "scene.h"

#include <string>
#include <vector>

namespace proxima::python {

namespace {

ScenePairOptions pair_options(const py::object& layers, const py::object& others, Integer threads)
{
    return {.layers = layers_of(layers, "layers"),
            .others = layers_of(others, "others"),
            .execution = {.threads = threads_of(threads)}};
}

py::object pair_columns(std::span<const InstancePair> pairs)
{
    auto a = new_array<std::int32_t>(pairs.size());
    auto b = new_array<std::int32_t>(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        a.mutable_data()[i] = static_cast<std::int32_t>(to_index(pairs[i].a));
        b.mutable_data()[i] = static_cast<std::int32_t>(to_index(pairs[i].b));
    }
    return result_type("InstancePairs")(a, b);
}

py::object in_contact(const Scene& self, const py::object& layers, const py::object& others,
                      Integer threads, const py::object& progress)
{
    ScenePairOptions options = pair_options(layers, others, threads);
    return pair_columns(run(progress, Duration::lengthy, [&](Progress* watched) {
        options.execution.progress = watched;
        return pairs_in_contact(self, options);
    }));
}

py::object boxes_within(const Scene& self, double distance, const py::object& layers,
                        const py::object& others, Integer threads, const py::object& progress)
{
    ScenePairOptions options = pair_options(layers, others, threads);
    return pair_columns(run(progress, Duration::lengthy, [&](Progress* watched) {
        options.execution.progress = watched;
        return overlapping_bounds(self, distance, options);
    }));
}

py::object pairs_within(const Scene& self, double distance, const py::object& layers,
                        const py::object& others, Integer threads, const py::object& progress)
{
    ScenePairOptions options = pair_options(layers, others, threads);
    const auto found = run(progress, Duration::lengthy, [&](Progress* watched) {
        options.execution.progress = watched;
        return pairs_within(self, distance, options);
    });
    const std::size_t count = found.size();
    auto a = new_array<std::int32_t>(count);
    auto b = new_array<std::int32_t>(count);
    auto distances = new_array<double>(count);
    auto point_a = new_rows<double>(count, 3);
    auto point_b = new_rows<double>(count, 3);
    auto triangle_a = new_array<std::int32_t>(count);
    auto triangle_b = new_array<std::int32_t>(count);
    for (std::size_t i = 0; i < count; ++i) {
        const NearInstances& pair = found[i];
        a.mutable_data()[i] = static_cast<std::int32_t>(to_index(pair.a));
        b.mutable_data()[i] = static_cast<std::int32_t>(to_index(pair.b));
        distances.mutable_data()[i] = pair.nearest.distance;
        elements_of<Vec3>(point_a)[i] = pair.point_a;
        elements_of<Vec3>(point_b)[i] = pair.point_b;
        elements_of<TriangleId>(triangle_a)[i] = pair.nearest.triangle_a;
        elements_of<TriangleId>(triangle_b)[i] = pair.nearest.triangle_b;
    }
    return result_type("NearInstances")(a, b, distances, point_a, point_b, triangle_a, triangle_b);
}

} // namespace

void bind_scene_pairs(py::class_<Scene>& scene)
{
    const py::int_ all(all_layers);
    scene
        .def(
            "in_contact", &in_contact, py::kw_only(), py::arg("layers") = all,
            py::arg("others") = all, py::arg("threads") = 0, py::arg("progress") = py::none(),
            R"(All pairs of instances whose surfaces meet, as InstancePairs. Exact; touching counts.

    layers, others  bits: one of each pair has a bit of `layers`, the other one of `others`

About 0.3 us per instance, and 1 to 30 us per pair whose boxes overlap.)")
        .def("within", &pairs_within, py::arg("distance"), py::kw_only(), py::arg("layers") = all,
             py::arg("others") = all, py::arg("threads") = 0, py::arg("progress") = py::none(),
             "All pairs of instances whose surfaces are at most a distance apart, in the scene's "
             "unit, as NearInstances. Layers as in in_contact().")
        .def("boxes_within", &boxes_within, py::arg("distance") = 0.0, py::kw_only(),
             py::arg("layers") = all, py::arg("others") = all, py::arg("threads") = 0,
             py::arg("progress") = py::none(),
             "All pairs of instances whose boxes, those of `bounds`, are at most a distance "
             "apart, as InstancePairs: for a search of your own. Layers as in in_contact().");
}

} // namespace proxima::python
