#include "arrays.h"
#include "index_methods.h"
#include "proxima/cast_ray.h"
#include "rays.h"
#include "run.h"

#include <optional>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

/// One number for all rays, or one for each.
class RangeArgument {
public:
    RangeArgument(const py::object& object, const char* name, std::size_t rays)
        : array_(doubles_of(object, name))
    {
        const bool fits = array_.ndim() == 0 ||
                          (array_.ndim() == 1 && array_.shape(0) == static_cast<py::ssize_t>(rays));
        if (!fits) refuse(name, "must be one number, or one for each ray");
    }
    [[nodiscard]] double operator[](std::size_t ray) const noexcept
    {
        return array_.data()[array_.ndim() == 0 ? 0 : ray];
    }

private:
    py::array_t<double> array_;
};

} // namespace

std::vector<Ray> rays_of(const py::object& origins, const py::object& directions,
                         const py::object& t_min, const py::object& t_max)
{
    const PointsArgument towards(directions, "directions");
    const py::array_t<double> from = doubles_of(origins, "origins");
    const bool one = from.ndim() == 1;
    std::optional<PointsArgument> each;
    Vec3 origin = Vec3::Zero();
    if (one) {
        origin = point_of(from, "origins");
    } else {
        each.emplace(from, "origins");
        if (each->size() != towards.size()) {
            refuse("origins", "are " + std::to_string(each->size()) + ", directions are " +
                                  std::to_string(towards.size()));
        }
    }
    const RangeArgument least(t_min, "t_min", towards.size());
    const RangeArgument most(t_max, "t_max", towards.size());
    std::vector<Ray> rays(towards.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        rays[i] = {one ? origin : each->points()[i], towards.points()[i], least[i], most[i]};
    }
    return rays;
}

Faces faces_named(const std::string& name)
{
    if (name == "both") return Faces::both;
    if (name == "front") return Faces::front;
    if (name == "back") return Faces::back;
    refuse("faces", R"(must be "both", "front" or "back", is ")" + name + "\"");
}

HitArrays::HitArrays(std::size_t size)
    : t_(new_array<double>(size)), triangle_(new_array<std::int32_t>(size)),
      u_(new_array<double>(size)), v_(new_array<double>(size)), to_t_(t_.mutable_data()),
      to_triangle_(triangle_.mutable_data()), to_u_(u_.mutable_data()), to_v_(v_.mutable_data())
{}

py::tuple HitArrays::columns() const
{
    return py::make_tuple(t_, triangle_, u_, v_);
}

namespace {

py::object cast_rays(const MeshIndex& index, const py::object& origins,
                     const py::object& directions, const py::object& t_min, const py::object& t_max,
                     const std::string& hits, const std::string& faces, Integer threads,
                     const py::object& progress)
{
    const std::vector<Ray> rays = rays_of(origins, directions, t_min, t_max);
    const Faces sides = faces_named(faces);
    const Threads thread_count = threads_of(threads);
    const auto options_for = [&](Progress* watched) {
        return RayBatchOptions{.faces = sides,
                               .execution = {.threads = thread_count, .progress = watched}};
    };
    const Duration duration = duration_of(rays.size());
    if (hits == "any") {
        auto answers = new_array<bool>(rays.size());
        run(progress, duration, [&](Progress* watched) {
            return any_hits(index, rays, elements_of<bool>(answers), options_for(watched));
        });
        return answers;
    }
    if (hits == "first") {
        std::vector<std::optional<RayHit>> found(rays.size());
        HitArrays arrays(rays.size());
        run(progress, duration, [&](Progress* watched) {
            auto status = closest_hits(index, rays, found, options_for(watched));
            for (std::size_t i = 0; i < found.size(); ++i) arrays.set(i, found[i].value_or(no_hit));
            return status;
        });
        return result_type("Hits")(*arrays.columns());
    }
    if (hits == "all") {
        const RayHitLists lists = run(progress, duration, [&](Progress* watched) {
            return all_hits(index, rays, options_for(watched));
        });
        HitArrays arrays(lists.hits.size());
        for (std::size_t i = 0; i < lists.hits.size(); ++i) arrays.set(i, lists.hits[i]);
        return result_type("HitLists")(
            array_of<std::int64_t>(std::span<const std::size_t>(lists.first)), *arrays.columns());
    }
    refuse("hits", R"(must be "first", "any" or "all", is ")" + hits + "\"");
}

} // namespace

void bind_rays(py::class_<MeshIndex>& index)
{
    index.def("cast", &cast_rays, py::arg("origins"), py::arg("directions"), py::kw_only(),
              py::arg("t_min") = 0.0, py::arg("t_max") = infinity, py::arg("hits") = "first",
              py::arg("faces") = "both", py::arg("threads") = 0, py::arg("progress") = py::none(),
              R"(What rays hit.

    origins     (n, 3) floats, or (3,): one for all rays
    directions  (n, 3) floats of any length: t is counted in it
    t_min, t_max  numbers or (n,) floats: the part of the rays that counts
    hits        "first": Hits; "any": (n,) bool; "all": HitLists
    faces       "both", "front" (seen counter-clockwise) or "back"

Raises InvalidInput where a ray is not finite or its direction is zero.)");
}

} // namespace proxima::python
