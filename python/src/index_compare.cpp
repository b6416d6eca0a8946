#include "arrays.h"
#include "index_methods.h"
#include "proxima/mesh_deviation.h"
#include "run.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>

namespace proxima::python {

namespace {

py::array_t<double> bounds_array(const DistanceBounds& bounds)
{
    return array_of<double>(std::span<const double>(std::array{bounds.lower, bounds.upper}));
}

/// A Deviation that Python hands back.
class DeviationArgument {
public:
    DeviationArgument(const py::object& deviation, const char* name)
        : deviation_(deviation), name_(name)
    {
        if (!py::isinstance(deviation, result_type("Deviation")))
            refuse_object(deviation, name, "a proxima.Deviation");
    }

    [[nodiscard]] DistanceBounds bounds(const char* field) const
    {
        const auto numbers = numbers_of(field, 2);
        if (!(0 <= numbers.at(0) && numbers.at(0) <= numbers.at(1)))
            refuse(path_of(field), "must be a lower bound of 0 or more and an upper one no less");
        return {numbers.at(0), numbers.at(1)};
    }

    [[nodiscard]] std::optional<MeanDeviation> mean() const
    {
        if (deviation_.attr("mean").is_none()) return std::nullopt;
        MeanDeviation mean;
        mean.mean = bounds("mean");
        mean.root_mean_square = bounds("root_mean_square");
        mean.area = not_negative("area");
        mean.area_error = not_negative("area_error");
        return mean;
    }

private:
    [[nodiscard]] std::string path_of(const char* field) const
    {
        return std::string(name_) + "." + field;
    }

    [[nodiscard]] py::array_t<double> numbers_of(const char* field, py::ssize_t count) const
    {
        const std::string path = path_of(field);
        auto numbers = doubles_of(deviation_.attr(field), path.c_str());
        const bool fits =
            count == 1 ? numbers.ndim() == 0 : numbers.ndim() == 1 && numbers.shape(0) == count;
        if (!fits) refuse(path, count == 1 ? "must be a number" : "must be two numbers");
        return numbers;
    }

    [[nodiscard]] double not_negative(const char* field) const
    {
        const double number = *numbers_of(field, 1).data();
        check_not_negative(number, path_of(field).c_str());
        return number;
    }

    const py::object& deviation_;
    const char* name_;
};

py::object columns_of_places(std::span<const FarPlace> places)
{
    const std::size_t size = places.size();
    auto distance = new_array<double>(size);
    auto point = new_rows<double>(size, 3);
    auto closest = new_rows<double>(size, 3);
    auto triangle = new_array<std::int32_t>(size);
    auto other_triangle = new_array<std::int32_t>(size);
    for (std::size_t i = 0; i < size; ++i) {
        distance.mutable_data()[i] = places[i].distance;
        elements_of<Vec3>(point)[i] = places[i].point_a;
        elements_of<Vec3>(closest)[i] = places[i].point_b;
        triangle.mutable_data()[i] = static_cast<std::int32_t>(to_index(places[i].triangle_a));
        other_triangle.mutable_data()[i] =
            static_cast<std::int32_t>(to_index(places[i].triangle_b));
    }
    return result_type("FarPlaces")(distance, point, closest, triangle, other_triangle);
}

py::object deviation(const MeshIndex& index, const MeshIndex& other, double tolerance, bool mean,
                     double mean_tolerance, Integer max_places, double place_spacing, Integer bins,
                     double histogram_end, Integer max_splits, Integer threads,
                     const py::object& progress)
{
    // Before the work, and by the names that they have here.
    check_not_negative(tolerance, "tolerance");
    check_not_negative(mean_tolerance, "mean_tolerance");
    check_not_negative(place_spacing, "place_spacing");
    if (!(histogram_end >= 0 && std::isfinite(histogram_end)))
        refuse("histogram_end", "must be finite and 0 or more");
    const std::uint64_t place_count = count_of(max_places, "max_places", max_deviation_places);
    const std::uint64_t bin_count = count_of(bins, "bins", max_histogram_bins);
    const std::uint64_t split_count = count_of(max_splits, "max_splits");
    if (bin_count != 0 && !mean) refuse("bins", "a histogram needs mean=True");
    Execution execution{.threads = threads_of(threads)};
    GreatestDeviationOptions greatest_options{.tolerance = tolerance,
                                              .max_places = static_cast<std::uint32_t>(place_count),
                                              .place_spacing = place_spacing,
                                              .max_splits = split_count};
    MeanDeviationOptions mean_options{.tolerance = mean_tolerance,
                                      .histogram_bins = static_cast<std::uint32_t>(bin_count),
                                      .histogram_end = histogram_end,
                                      .max_splits = split_count};
    const auto measure = [&](auto&& function, auto& options) {
        return run(progress, Duration::lengthy, [&](Progress* watched) {
            execution.progress = watched;
            options.execution = execution;
            return function(index, other, options);
        });
    };
    const GreatestDeviation greatest = measure(greatest_deviation, greatest_options);
    py::dict columns;
    columns["complete"] = greatest.is_complete;
    if (mean) {
        if (histogram_end == 0) mean_options.histogram_end = greatest.distance.upper;
        if (mean_options.histogram_end == 0) mean_options.histogram_bins = 0; // all distances are 0
        const MeanDeviation found = measure(mean_deviation, mean_options);
        columns["mean"] = bounds_array(found.mean);
        columns["root_mean_square"] = bounds_array(found.root_mean_square);
        columns["mean_complete"] = found.is_complete;
        columns["area"] = found.area;
        columns["area_error"] = found.area_error;
        if (!found.histogram.empty()) {
            columns["histogram"] = array_of<double>(std::span<const double>(found.histogram));
            columns["histogram_end"] = mean_options.histogram_end;
        }
    }
    if (place_count > 0) {
        columns["places"] = columns_of_places(greatest.places);
        columns["all_places"] = greatest.has_all_places;
    }
    return result_type("Deviation")(bounds_array(greatest.distance), vector_of(greatest.point_a),
                                    vector_of(greatest.point_b), to_index(greatest.triangle_a),
                                    to_index(greatest.triangle_b), **columns);
}

py::object two_sided(const py::object& there, const py::object& back)
{
    const DeviationArgument a_to_b(there, "there");
    const DeviationArgument b_to_a(back, "back");
    const auto greatest =
        bounds_array(both_ways(a_to_b.bounds("greatest"), b_to_a.bounds("greatest")));
    const ResultType type = result_type("TwoSidedDeviation");
    const auto mean_there = a_to_b.mean();
    const auto mean_back = b_to_a.mean();
    if (!mean_there || !mean_back) return type(greatest);
    const TwoSidedMean both = both_ways(*mean_there, *mean_back);
    return type(greatest, bounds_array(both.mean), bounds_array(both.root_mean_square),
                bounds_array(both.larger_mean), bounds_array(both.larger_root_mean_square));
}

} // namespace

void bind_comparisons(py::module_& module, py::class_<MeshIndex>& index)
{
    index.def(
        "deviation", &deviation, py::arg("other"), py::kw_only(), py::arg("tolerance") = 0.0,
        py::arg("mean") = true, py::arg("mean_tolerance") = 0.0, py::arg("max_places") = 0,
        py::arg("place_spacing") = 0.0, py::arg("bins") = 0, py::arg("histogram_end") = 0.0,
        py::arg("max_splits") = default_deviation_splits, py::arg("threads") = 0,
        py::arg("progress") = py::none(),
        R"(How far this surface is from another one at most and on average, as a Deviation: intervals that hold the true numbers.

    tolerance       how far the bounds of the greatest distance may be apart, in the mesh's unit; 0: 1e-6 of the meshes' common diagonal
    mean            with mean and root mean square by area, which take longer
    mean_tolerance  the same of the mean; 0: 1e-5 of the diagonal
    max_places      up to so many points that are as far as any within the tolerance, 256 at most
    place_spacing   how far these are from each other at least, in the mesh's unit; 0: 0.01 of the diagonal
    bins            with a histogram of the distances by area, of so many bins, 4096 at most; needs the mean
    histogram_end   where its last bin ends, in the mesh's unit; 0: at the upper bound of the greatest distance
    max_splits      how often parts of triangles are cut at most; then the bounds are wider

Looks from this surface to the other alone: both_ways(a.deviation(b), b.deviation(a)) has the Hausdorff distance and the means
over both. Raises InvalidInput for an empty mesh, and with the mean for one without area; LimitExceeded, Cancelled.)");
    module.def(
        "both_ways", &two_sided, py::arg("there"), py::arg("back"),
        R"(What two Deviations, from A to B and from B to A, say of both surfaces, as a TwoSidedDeviation.

    proxima.both_ways(a.deviation(b), b.deviation(a)).greatest    # bounds of the Hausdorff distance

Without means where one of them has none.)");
}

} // namespace proxima::python
