#include "cli/deviation_answer.h"

#include "cli/json_numbers.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace proxima {

namespace {

using DeviationJson = nlohmann::ordered_json;

DeviationJson bounds_json(const DistanceBounds& both)
{
    return {both.lower, both.upper};
}

std::string place_text(const Vec3& a, TriangleId triangle_a, const Vec3& b, TriangleId triangle_b)
{
    return fmt::format("    at ({:.9g}, {:.9g}, {:.9g}) of triangle {}, closest ({:.9g}, {:.9g}, "
                       "{:.9g}) of triangle {}\n",
                       a.x(), a.y(), a.z(), to_index(triangle_a), b.x(), b.y(), b.z(),
                       to_index(triangle_b));
}

std::string mean_text(const DistanceBounds& mean, const DistanceBounds& root,
                      const std::string& remark)
{
    return fmt::format("  mean                {:.9g} to {:.9g}{}\n"
                       "  root mean square    {:.9g} to {:.9g}\n",
                       mean.lower, mean.upper, remark, root.lower, root.upper);
}

std::string one_way_text(const OneWayDeviation& way, const char* from, const char* to)
{
    const GreatestDeviation& greatest = way.greatest;
    std::string text =
        fmt::format("from {} to {}\n"
                    "  greatest            {:.12g} to {:.12g}{}, {:.3f} s\n",
                    from, to, greatest.distance.lower, greatest.distance.upper,
                    greatest.is_complete ? "" : " (tolerance not reached)", way.greatest_seconds);
    if (greatest.places.empty()) {
        text += place_text(greatest.point_a, greatest.triangle_a, greatest.point_b,
                           greatest.triangle_b);
    }
    for (const FarPlace& place : greatest.places)
        text += place_text(place.point_a, place.triangle_a, place.point_b, place.triangle_b);
    if (!greatest.places.empty() && !greatest.has_all_places)
        text += "    and there are more such places\n";
    if (!way.mean) return text;
    return text + mean_text(way.mean->mean, way.mean->root_mean_square,
                            fmt::format("{}, {:.3f} s",
                                        way.mean->is_complete ? "" : " (tolerance not reached)",
                                        way.mean_seconds));
}

DeviationJson one_way_json(const OneWayDeviation& way, bool has_places)
{
    const GreatestDeviation& greatest = way.greatest;
    DeviationJson json = {{"greatest", bounds_json(greatest.distance)},
                          {"complete", greatest.is_complete},
                          {"point_a", json_numbers(greatest.point_a)},
                          {"point_b", json_numbers(greatest.point_b)},
                          {"triangle_a", to_index(greatest.triangle_a)},
                          {"triangle_b", to_index(greatest.triangle_b)},
                          {"splits", greatest.splits},
                          {"seconds", way.greatest_seconds}};
    if (has_places) {
        DeviationJson places = DeviationJson::array();
        for (const FarPlace& place : greatest.places) {
            places.push_back({{"distance", place.distance},
                              {"point_a", json_numbers(place.point_a)},
                              {"point_b", json_numbers(place.point_b)},
                              {"triangle_a", to_index(place.triangle_a)},
                              {"triangle_b", to_index(place.triangle_b)}});
        }
        json["places"] = places;
        json["all_places"] = greatest.has_all_places;
    }
    if (way.mean) {
        json["mean"] = bounds_json(way.mean->mean);
        json["root_mean_square"] = bounds_json(way.mean->root_mean_square);
        json["mean_complete"] = way.mean->is_complete;
        json["area"] = way.mean->area;
        json["histogram"] = way.mean->histogram;
        json["mean_splits"] = way.mean->splits;
        json["mean_seconds"] = way.mean_seconds;
    }
    return json;
}

} // namespace

std::string deviation_text(std::span<const OneWayDeviation> ways, const DistanceBounds& hausdorff)
{
    std::string text = one_way_text(ways[0], "A", "B");
    if (ways.size() < 2) return text;
    text += one_way_text(ways[1], "B", "A");
    text +=
        fmt::format("Hausdorff distance    {:.12g} to {:.12g}\n", hausdorff.lower, hausdorff.upper);
    if (!ways[0].mean || !ways[1].mean) return text;
    const TwoSidedMean both = both_ways(*ways[0].mean, *ways[1].mean);
    text += "over both surfaces by area\n" + mean_text(both.mean, both.root_mean_square, "");
    text += "larger of both ways\n" + mean_text(both.larger_mean, both.larger_root_mean_square, "");
    return text;
}

nlohmann::ordered_json deviation_json(std::span<const OneWayDeviation> ways,
                                      const DistanceBounds& hausdorff, bool has_places)
{
    DeviationJson json = {{"a_to_b", one_way_json(ways[0], has_places)}};
    if (ways.size() < 2) return json;
    json["b_to_a"] = one_way_json(ways[1], has_places);
    json["hausdorff"] = bounds_json(hausdorff);
    if (!ways[0].mean || !ways[1].mean) return json;
    const TwoSidedMean both = both_ways(*ways[0].mean, *ways[1].mean);
    json["both_ways"] = {{"mean", bounds_json(both.mean)},
                         {"root_mean_square", bounds_json(both.root_mean_square)},
                         {"larger_mean", bounds_json(both.larger_mean)},
                         {"larger_root_mean_square", bounds_json(both.larger_root_mean_square)}};
    return json;
}

} // namespace proxima
