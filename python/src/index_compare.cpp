#include "arrays.h"
#include "index_methods.h"
#include "proxima/mesh_deviation.h"
#include "run.h"

#include <array>

namespace proxima::python {

namespace {

py::array_t<double> numbers(std::span<const double> values)
{
    return array_of<double>(values);
}

py::array_t<double> bounds_array(const DistanceBounds& bounds)
{
    return numbers(std::array{bounds.lower, bounds.upper});
}

py::object deviation(const MeshIndex& index, const MeshIndex& other, double tolerance, bool mean,
                     double mean_tolerance, int threads, const py::object& progress)
{
    const Threads thread_count = threads_of(threads);
    const GreatestDeviation greatest = run(progress, Duration::lengthy, [&](Progress* watched) {
        return greatest_deviation(
            index, other,
            {.tolerance = tolerance, .execution = {.threads = thread_count, .progress = watched}});
    });
    py::object mean_bounds = py::none();
    py::object square_bounds = py::none();
    if (mean) {
        const MeanDeviation found = run(progress, Duration::lengthy, [&](Progress* watched) {
            return mean_deviation(index, other,
                                  {.tolerance = mean_tolerance,
                                   .execution = {.threads = thread_count, .progress = watched}});
        });
        mean_bounds = bounds_array(found.mean);
        square_bounds = bounds_array(found.root_mean_square);
    }
    return result_type("Deviation")(bounds_array(greatest.distance), vector_of(greatest.point_a),
                                    vector_of(greatest.point_b), to_index(greatest.triangle_a),
                                    to_index(greatest.triangle_b), mean_bounds, square_bounds);
}

} // namespace

void bind_comparisons(py::class_<MeshIndex>& index)
{
    index.def(
        "deviation", &deviation, py::arg("other"), py::kw_only(), py::arg("tolerance") = 0.0,
        py::arg("mean") = true, py::arg("mean_tolerance") = 0.0, py::arg("threads") = 0,
        py::arg("progress") = py::none(),
        R"(How far this surface is from another one at most and on average, as a Deviation: intervals that hold the true numbers.

    tolerance       how far the bounds of the greatest distance may be apart; 0: 1e-6 of the meshes' common diagonal
    mean            with mean and root mean square by area, which take longer
    mean_tolerance  the same of the mean; 0: 1e-5 of the diagonal

Looks from this surface to the other alone; the larger of both ways is the Hausdorff distance.)");
}

} // namespace proxima::python
