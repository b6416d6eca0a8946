#include "arrays.h"
#include "bindings.h"
#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/cull.h"
#include "proxima/index_io.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"
#include "proxima/signed_distance.h"
#include "proxima/view_volume.h"
#include "run.h"

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>
#include <string>
#include <vector>

namespace proxima::python {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Batches from here on run where Ctrl-C can stop them.
constexpr std::size_t lengthy_batch = 4096;

Duration duration_of(std::size_t queries)
{
    return queries < lengthy_batch ? Duration::brief : Duration::lengthy;
}

/// False, True, or bytes. Nothing where there are to be no lists.
std::optional<ListOptions> list_options_of(const py::object& lists)
{
    if (lists.is_none() || lists.ptr() == Py_False) return std::nullopt;
    if (lists.ptr() == Py_True) return ListOptions{};
    if (!py::isinstance<py::int_>(lists))
        refuse("lists", "must be False, True or a number of bytes");
    const auto bytes = lists.cast<long long>();
    if (bytes <= 0) refuse("lists", "must be False, True or a number of bytes above 0");
    return ListOptions{.list_bytes = static_cast<std::uint64_t>(bytes)};
}

MeshIndex build(const TriangleMesh& mesh, const py::object& lists, bool distances, bool signs,
                int threads, const py::object& progress)
{
    const auto list_options = list_options_of(lists);
    const Threads thread_count = threads_of(threads);
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        const Execution execution{.threads = thread_count, .progress = watched};
        auto index = build_mesh_index(mesh, {.execution = execution});
        if (index && list_options) {
            ListOptions options = *list_options;
            options.execution = execution;
            index = with_lists(*index, options);
        }
        if (index && distances) index = with_slabs(*index, {.execution = execution});
        if (index && signs) index = with_signs(*index, {.execution = execution});
        return index;
    });
}

// ---- closest features

/// The names of Closest's columns, in its order.
constexpr std::array<const char*, 6> closest_columns{"distance",     "point",   "triangle",
                                                     "feature_kind", "feature", "barycentric"};

/// Arrays that a batch writes to; None where a column is not wanted.
struct ClosestArrays {
    py::object distance = py::none();
    py::object point = py::none();
    py::object triangle = py::none();
    py::object feature_kind = py::none();
    py::object feature = py::none();
    py::object barycentric = py::none();

    [[nodiscard]] std::array<py::object*, 6> all()
    {
        return {&distance, &point, &triangle, &feature_kind, &feature, &barycentric};
    }
};

template <class T>
void check_output(const py::object& object, const char* name, std::size_t rows, std::size_t columns)
{
    if (object.is_none()) return;
    const bool fits = py::isinstance<py::array_t<T, py::array::c_style>>(object) && [&] {
        const auto array = py::reinterpret_borrow<py::array>(object);
        const auto ndim = columns == 1 ? 1 : 2;
        return array.writeable() && array.ndim() == ndim &&
               array.shape(0) == static_cast<py::ssize_t>(rows) &&
               (ndim == 1 || array.shape(1) == static_cast<py::ssize_t>(columns));
    }();
    if (!fits) {
        refuse(std::string("out.") + name,
               "must be an earlier answer for as many points, whose arrays can be written to");
    }
}

ClosestArrays closest_arrays(std::size_t size, const py::object& columns, const py::object& out)
{
    ClosestArrays arrays;
    if (!out.is_none()) {
        if (!columns.is_none()) refuse("columns", "are those of out: leave them out");
        const auto all = arrays.all();
        for (std::size_t i = 0; i < all.size(); ++i) *all[i] = out.attr(closest_columns[i]);
        check_output<double>(arrays.distance, "distance", size, 1);
        check_output<double>(arrays.point, "point", size, 3);
        check_output<std::int32_t>(arrays.triangle, "triangle", size, 1);
        check_output<std::uint8_t>(arrays.feature_kind, "feature_kind", size, 1);
        check_output<std::int32_t>(arrays.feature, "feature", size, 1);
        check_output<double>(arrays.barycentric, "barycentric", size, 3);
        return arrays;
    }
    std::vector<std::string> wanted(closest_columns.begin(), closest_columns.end());
    if (!columns.is_none()) wanted = columns.cast<std::vector<std::string>>();
    for (const std::string& name : wanted) {
        if (name == "distance") {
            arrays.distance = new_array<double>(size);
        } else if (name == "point") {
            arrays.point = new_rows<double>(size, 3);
        } else if (name == "triangle") {
            arrays.triangle = new_array<std::int32_t>(size);
        } else if (name == "feature_kind") {
            arrays.feature_kind = new_array<std::uint8_t>(size);
        } else if (name == "feature") {
            arrays.feature = new_array<std::int32_t>(size);
        } else if (name == "barycentric") {
            arrays.barycentric = new_rows<double>(size, 3);
        } else {
            refuse("columns", "has no column \"" + name + "\"");
        }
    }
    return arrays;
}

template <class As, class T>
std::span<As> elements_of_any(const py::object& object)
{
    if (object.is_none()) return {};
    auto array = py::reinterpret_borrow<py::array_t<T>>(object);
    return elements_of<As>(array);
}

py::object closest(const MeshIndex& index, const py::object& points, const py::object& columns,
                   const py::object& out, int threads, const py::object& progress)
{
    const PointsArgument argument(points, "points");
    ClosestArrays arrays = closest_arrays(argument.size(), columns, out);
    const ClosestOutputs outputs{
        .triangles = elements_of_any<TriangleId, std::int32_t>(arrays.triangle),
        .distances = elements_of_any<double, double>(arrays.distance),
        .points = elements_of_any<Vec3, double>(arrays.point),
        .feature_kinds = elements_of_any<FeatureKind, std::uint8_t>(arrays.feature_kind),
        .feature_ids = elements_of_any<std::uint32_t, std::int32_t>(arrays.feature),
        .barycentrics = elements_of_any<std::array<double, 3>, double>(arrays.barycentric)};
    const Threads thread_count = threads_of(threads);
    run(progress, duration_of(argument.size()), [&](Progress* watched) {
        return closest_features(index, argument.points(), outputs,
                                {.execution = {.threads = thread_count, .progress = watched}});
    });
    if (!out.is_none()) return out;
    return result_type("Closest")(arrays.distance, arrays.point, arrays.triangle,
                                  arrays.feature_kind, arrays.feature, arrays.barycentric);
}

py::object signed_distance_of(const MeshIndex& index, const py::object& points, bool method,
                              int threads, const py::object& progress)
{
    if (!index.has_signs())
        refuse("index", "has no signs: build it with signs=True, or call with_signs()");
    const PointsArgument argument(points, "points");
    auto distances = new_array<double>(argument.size());
    auto methods = new_array<std::uint8_t>(method ? argument.size() : 0);
    const SignedOutputs outputs{.distances = elements_of<double>(distances),
                                .methods = elements_of<SignMethod>(methods)};
    const Threads thread_count = threads_of(threads);
    run(progress, duration_of(argument.size()), [&](Progress* watched) {
        return signed_distances(index, argument.points(), outputs,
                                {.execution = {.threads = thread_count, .progress = watched}});
    });
    if (method) return py::make_tuple(distances, methods);
    return distances;
}

// ---- rays

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

/// Columns of hits.
class HitArrays {
public:
    explicit HitArrays(std::size_t size)
        : t_(new_array<double>(size)), triangle_(new_array<std::int32_t>(size)),
          u_(new_array<double>(size)), v_(new_array<double>(size)), to_t_(t_.mutable_data()),
          to_triangle_(triangle_.mutable_data()), to_u_(u_.mutable_data()), to_v_(v_.mutable_data())
    {}

    void set(std::size_t i, const RayHit& hit) noexcept
    {
        to_t_[i] = hit.t;
        to_triangle_[i] = static_cast<std::int32_t>(to_index(hit.triangle));
        to_u_[i] = hit.u;
        to_v_[i] = hit.v;
    }

    [[nodiscard]] py::tuple columns() const { return py::make_tuple(t_, triangle_, u_, v_); }

private:
    py::array_t<double> t_;
    py::array_t<std::int32_t> triangle_;
    py::array_t<double> u_;
    py::array_t<double> v_;
    double* to_t_;
    std::int32_t* to_triangle_;
    double* to_u_;
    double* to_v_;
};

py::object cast_rays(const MeshIndex& index, const py::object& origins,
                     const py::object& directions, const py::object& t_min, const py::object& t_max,
                     const std::string& hits, const std::string& faces, int threads,
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
            for (std::size_t i = 0; i < found.size(); ++i)
                arrays.set(i, found[i].value_or(RayHit{infinity, no_triangle, nan, nan}));
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

// ---- views

ViewVolume volume_of(const py::object& planes)
{
    const py::array_t<double> array = doubles_of(planes, "planes");
    if (array.ndim() != 2 || array.shape(1) != 4)
        refuse("planes", "must have shape (n, 4): normal and offset of each");
    std::vector<ViewPlane> list;
    for (py::ssize_t i = 0; i < array.shape(0); ++i) {
        const double* const plane = array.data() + 4 * i;
        list.push_back({Vec3(plane), plane[3]});
    }
    return value_of(make_view_volume(list));
}

py::array planes_of(const ViewVolume& volume)
{
    auto array = new_rows<double>(volume.planes().size(), 4);
    double* to = array.mutable_data();
    for (const ViewPlane& plane : volume.planes()) {
        for (int k = 0; k < 3; ++k) *to++ = plane.normal[k];
        *to++ = plane.offset;
    }
    return array;
}

py::array visible(const MeshIndex& index, const py::object& planes, bool exact)
{
    const ViewVolume volume = volume_of(planes);
    std::vector<TriangleId> ids;
    {
        const py::gil_scoped_release unlocked;
        visible_triangles(index, volume, exact ? CullMode::exact : CullMode::conservative, ids);
    }
    return array_of<std::int32_t>(std::span<const TriangleId>(ids));
}

// ---- two meshes

py::object intersect(const MeshIndex& index, const MeshIndex& other, const py::object& poses,
                     bool pairs, int threads, const py::object& progress)
{
    const Poses moved = poses_of(poses);
    const Threads thread_count = threads_of(threads);
    const auto options_for = [&](Progress* watched) {
        return PairOptions{.execution = {.threads = thread_count, .progress = watched}};
    };
    if (!pairs) {
        auto answers = new_array<bool>(moved.poses.size());
        run(progress, Duration::lengthy, [&](Progress* watched) {
            return meshes_intersect(index, other, moved.poses, elements_of<bool>(answers),
                                    options_for(watched));
        });
        if (moved.single) return py::bool_(answers.at(0));
        return answers;
    }
    const PairLists lists = run(progress, Duration::lengthy, [&](Progress* watched) {
        return intersecting_pairs(index, other, moved.poses, options_for(watched));
    });
    auto a = new_array<std::int32_t>(lists.pairs.size());
    auto b = new_array<std::int32_t>(lists.pairs.size());
    for (std::size_t i = 0; i < lists.pairs.size(); ++i) {
        a.mutable_data()[i] = static_cast<std::int32_t>(to_index(lists.pairs[i].a));
        b.mutable_data()[i] = static_cast<std::int32_t>(to_index(lists.pairs[i].b));
    }
    if (moved.single) return result_type("Pairs")(a, b);
    return result_type("PairLists")(
        array_of<std::int64_t>(std::span<const std::size_t>(lists.first)), a, b);
}

py::object distance_to(const MeshIndex& index, const MeshIndex& other, const py::object& poses,
                       double farthest, const py::object& progress)
{
    const Poses moved = poses_of(poses);
    const std::size_t count = moved.poses.size();
    auto distance = new_array<double>(count);
    auto point_a = new_rows<double>(count, 3);
    auto point_b = new_rows<double>(count, 3);
    auto triangle_a = new_array<std::int32_t>(count);
    auto triangle_b = new_array<std::int32_t>(count);
    const auto points_a = elements_of<Vec3>(point_a);
    const auto points_b = elements_of<Vec3>(point_b);
    double* const distances = distance.mutable_data();
    const auto triangles_a = elements_of<TriangleId>(triangle_a);
    const auto triangles_b = elements_of<TriangleId>(triangle_b);
    run(progress, Duration::lengthy, [&](Progress* watched) -> Status {
        watched->begin_stage("distances between meshes", count);
        const MeshDistance none{infinity, Vec3::Constant(nan), Vec3::Constant(nan), no_triangle,
                                no_triangle};
        MeshDistance last;
        for (std::size_t i = 0; i < count; ++i) {
            if (watched->cancelled())
                return fail(ErrorCode::cancelled, "the search for distances was cancelled");
            const auto found =
                mesh_distance(index, other, moved.poses[i],
                              {.farthest = farthest, .start_from = i == 0 ? nullptr : &last});
            const MeshDistance& answer = found ? *found : none;
            if (found) last = *found;
            distances[i] = answer.distance;
            points_a[i] = answer.point_a;
            points_b[i] = answer.point_b;
            triangles_a[i] = answer.triangle_a;
            triangles_b[i] = answer.triangle_b;
            watched->advance(1);
        }
        return {};
    });
    const py::object type = result_type("Distances");
    if (!moved.single) return type(distance, point_a, point_b, triangle_a, triangle_b);
    const py::int_ first(0);
    return type(distance[first], point_a[first], point_b[first], triangle_a[first],
                triangle_b[first]);
}

// ---- neighbourhoods

py::object within(const MeshIndex& index, const py::object& points, double radius,
                  const py::object& progress)
{
    const PointsArgument argument(points, "points");
    if (!(radius >= 0)) refuse("radius", "must be 0 or more");
    std::vector<std::size_t> first{0};
    std::vector<TriangleId> triangles;
    run(progress, duration_of(argument.size()), [&](Progress* watched) -> Status {
        if (watched != nullptr) watched->begin_stage("triangles within", argument.size());
        std::vector<TriangleId> buffer(std::min<std::size_t>(index.triangle_count(), 1024));
        for (std::size_t i = 0; i < argument.size(); ++i) {
            const Vec3& p = argument.points()[i];
            if (!p.allFinite()) {
                return fail(ErrorCode::invalid_argument,
                            "point " + std::to_string(i) + " is not finite: leave it out",
                            "points");
            }
            Neighbourhood found = collect_triangles(index, p, radius, buffer);
            if (!found.complete) {
                buffer.resize(index.triangle_count());
                found = collect_triangles(index, p, radius, buffer);
            }
            triangles.insert(triangles.end(), buffer.begin(),
                             buffer.begin() + static_cast<std::ptrdiff_t>(found.written));
            first.push_back(triangles.size());
            if (watched == nullptr) continue;
            if (watched->cancelled()) return fail(ErrorCode::cancelled, "the search was cancelled");
            watched->advance(1);
        }
        return {};
    });
    return result_type("Neighbours")(
        array_of<std::int64_t>(std::span<const std::size_t>(first)),
        array_of<std::int32_t>(std::span<const TriangleId>(triangles)));
}

// ---- files

void save(const MeshIndex& index, const std::filesystem::path& path, const py::object& progress)
{
    run(progress, Duration::lengthy, [&](Progress* watched) {
        return save_index(index, path, {.execution = {.progress = watched}});
    });
}

MeshIndex load(const std::filesystem::path& path, bool map, const py::object& progress)
{
    return run(progress, Duration::lengthy, [&](Progress* watched) {
        return load_index(path, {.access = map ? FileAccess::map : FileAccess::read,
                                 .execution = {.progress = watched}});
    });
}

/// The bytes of the index's file, for pickle.
py::bytes bytes_of_index(const MeshIndex& index)
{
    const py::object folder = py::module_::import("tempfile").attr("TemporaryDirectory")();
    const py::object path =
        py::module_::import("os").attr("path").attr("join")(folder.attr("name"), "pickled.pxi");
    save(index, path.cast<std::filesystem::path>(), py::none());
    const py::object file = py::module_::import("io").attr("FileIO")(path);
    py::bytes bytes = file.attr("readall")();
    file.attr("close")();
    folder.attr("cleanup")();
    return bytes;
}

MeshIndex index_of_bytes(const py::bytes& bytes)
{
    const std::string_view content = bytes;
    constexpr std::size_t alignment = 128;
    const std::size_t size = (content.size() + alignment - 1) / alignment * alignment;
    const std::shared_ptr<void> storage(std::aligned_alloc(alignment, size), std::free);
    if (storage == nullptr) throw std::bad_alloc();
    std::memcpy(storage.get(), content.data(), content.size());
    return value_of(load_index({static_cast<const std::byte*>(storage.get()), content.size()},
                               storage, "pickled index"));
}

std::string represent(const MeshIndex& index)
{
    std::string text = "<proxima.Index: " + std::to_string(index.triangle_count()) + " triangles";
    if (index.has_lists()) text += ", lists";
    if (index.has_slabs()) text += ", distances";
    if (index.has_signs()) text += ", signs";
    return text + ", " + std::to_string(index.bytes()) + " bytes>";
}

} // namespace

void bind_index(py::module_& module)
{
    py::class_<MeshIndex> index(module, "Index",
                                R"(The index of a mesh: built once, it answers every query.

Index(mesh, *, lists=False, distances=False, signs=False, threads=0, progress=None)

    lists      True, or their largest size in bytes: closest features in bounded time, about 100 us of work and 520
               bytes per triangle
    distances  True: distances between meshes are found sooner, 3 bytes per triangle
    signs      True: tells inside from outside, needed by signed_distance; 3 to 10 us of work per triangle
    threads    0 = all of the machine; results never depend on it
    progress   called as progress(stage, fraction) twenty times a second; returning False raises Cancelled

Immutable; holds a copy of the triangles; any number of threads may query it. About 0.5 us of work and 120 bytes per
triangle, 160 where positions are not floats. Ctrl-C stops building and batches. Raises InvalidInput for a mesh without
triangles or with NaN.)");
    index
        .def(py::init(&build), py::arg("mesh"), py::kw_only(), py::arg("lists") = false,
             py::arg("distances") = false, py::arg("signs") = false, py::arg("threads") = 0,
             py::arg("progress") = py::none())
        .def("closest", &closest, py::arg("points"), py::kw_only(), py::arg("columns") = py::none(),
             py::arg("out") = py::none(), py::arg("threads") = 0, py::arg("progress") = py::none(),
             R"(The closest points of the mesh, as Closest: arrays by column.

    points   (n, 3) floats. float64 in C order is used in place; all else is copied once
    columns  names of the columns to compute, the others are None. ("distance", "triangle") is quickest
    out      an earlier Closest for n points: its arrays are written again and it is returned

Raises InvalidInput where a point is not finite. 0.5 to 5 us a point on one thread.)")
        .def(
            "signed_distance", &signed_distance_of, py::arg("points"), py::kw_only(),
            py::arg("method") = false, py::arg("threads") = 0, py::arg("progress") = py::none(),
            R"(Signed distances of points (n, 3) from the mesh: (n,) float64, negative inside, in the mesh's unit.

With method=True a pair: distances, and (n,) uint8 that say how each sign was found, see SIGN_METHODS. Inside is where
the winding number is at least 1/2, so that meshes with holes have an inside too. Needs signs.)")
        .def("cast", &cast_rays, py::arg("origins"), py::arg("directions"), py::kw_only(),
             py::arg("t_min") = 0.0, py::arg("t_max") = infinity, py::arg("hits") = "first",
             py::arg("faces") = "both", py::arg("threads") = 0, py::arg("progress") = py::none(),
             R"(What rays hit.

    origins     (n, 3) floats, or (3,): one for all rays
    directions  (n, 3) floats of any length: t is counted in it
    t_min, t_max  numbers or (n,) floats: the part of the rays that counts
    hits        "first": Hits; "any": (n,) bool; "all": HitLists
    faces       "both", "front" (seen counter-clockwise) or "back"

Raises InvalidInput where a ray is not finite or its direction is zero.)")
        .def(
            "visible", &visible, py::arg("planes"), py::kw_only(), py::arg("exact") = false,
            R"(Ids of the triangles in a view volume, (m,) int32, ascending. Occlusion is not tested.

    planes  (k, 4) floats a, b, c, d: inside is where a x + b y + c z + d >= 0 for all; see perspective() and
            orthographic()
    exact   True: exactly those that have a point in common with the volume, else also some near its edges)")
        .def("intersect", &intersect, py::arg("other"), py::arg("poses") = py::none(),
             py::kw_only(), py::arg("pairs") = true, py::arg("threads") = 0,
             py::arg("progress") = py::none(),
             R"(Where this mesh and another one, moved by poses, meet. Exact; touching counts.

    poses  None, (3, 4) or (4, 4), or (n, 3, 4) or (n, 4, 4) floats: rigid, row-major, applied to `other`
    pairs  True: the pairs of triangles that meet, Pairs for one pose, PairLists for several; False: bool or (n,) bool)")
        .def(
            "distance_to", &distance_to, py::arg("other"), py::arg("poses") = py::none(),
            py::kw_only(), py::arg("farthest") = infinity, py::arg("progress") = py::none(),
            R"(How far this surface and another one, moved by poses as in intersect(), are apart, as Distances.

0 if and only if they touch. Beyond `farthest`, in the mesh's unit, nothing is found.)")
        .def("within", &within, py::arg("points"), py::arg("radius"), py::kw_only(),
             py::arg("progress") = py::none(),
             "The triangles within a radius of points (n, 3), in the mesh's unit, as Neighbours.")
        .def("save", &save, py::arg("path"), py::kw_only(), py::arg("progress") = py::none(),
             "Writes the index with all that it has to a .pxi file, whole or not at all.")
        .def_static("load", &load, py::arg("path"), py::kw_only(), py::arg("map") = false,
                    py::arg("progress") = py::none(),
                    R"(The index of a .pxi file.

map=True uses the file's own pages, which processes share: the file must not be shortened meanwhile. Raises FileMissing,
or InvalidInput for a file that is damaged or none of ours.)")
        .def(
            "with_lists",
            [](const MeshIndex& self, const py::object& lists, int threads,
               const py::object& progress) {
                ListOptions options = list_options_of(lists).value_or(ListOptions{});
                options.execution.threads = threads_of(threads);
                return run(progress, Duration::lengthy, [&](Progress* watched) {
                    options.execution.progress = watched;
                    return proxima::with_lists(self, options);
                });
            },
            py::arg("lists") = true, py::kw_only(), py::arg("threads") = 0,
            py::arg("progress") = py::none(),
            "The index with closest-feature lists; shares all else. See Index for `lists`.")
        .def(
            "with_distances",
            [](const MeshIndex& self, int threads, const py::object& progress) {
                const Threads thread_count = threads_of(threads);
                return run(progress, Duration::lengthy, [&](Progress* watched) {
                    return with_slabs(
                        self, {.execution = {.threads = thread_count, .progress = watched}});
                });
            },
            py::kw_only(), py::arg("threads") = 0, py::arg("progress") = py::none(),
            "The index with what makes distances between meshes faster; shares all else.")
        .def(
            "with_signs",
            [](const MeshIndex& self, int threads, const py::object& progress) {
                const Threads thread_count = threads_of(threads);
                return run(progress, Duration::lengthy, [&](Progress* watched) {
                    return proxima::with_signs(
                        self, {.execution = {.threads = thread_count, .progress = watched}});
                });
            },
            py::kw_only(), py::arg("threads") = 0, py::arg("progress") = py::none(),
            "The index with signs, which signed_distance needs; shares all else.")
        .def_property_readonly("triangle_count", &MeshIndex::triangle_count)
        .def_property_readonly("vertex_count", &MeshIndex::vertex_count)
        .def_property_readonly("edge_count", &MeshIndex::edge_count)
        .def_property_readonly("nbytes", &MeshIndex::bytes,
                               "Bytes of all arrays, including those shared with other indexes.")
        .def_property_readonly("has_lists", &MeshIndex::has_lists)
        .def_property_readonly("has_distances", &MeshIndex::has_slabs)
        .def_property_readonly("has_signs", &MeshIndex::has_signs)
        .def(
            "mesh", [](const MeshIndex& self) { return value_of(mesh_of(self)); },
            "The mesh that it was built from. Vertices without a triangle were not kept.")
        .def("__repr__", &represent)
        .def("__copy__", [](const py::object& self) { return self; })
        .def("__deepcopy__", [](const py::object& self, const py::dict&) { return self; })
        .def(py::pickle(&bytes_of_index, &index_of_bytes));

    module.def(
        "perspective",
        [](const py::object& eye, const py::object& forward, const py::object& up,
           double field_of_view, double aspect, double near, double far) {
            return planes_of(value_of(
                make_perspective_volume({point_of(eye, "eye"), point_of(forward, "forward"),
                                         point_of(up, "up"), field_of_view, aspect, near, far})));
        },
        py::arg("eye"), py::arg("forward"), py::arg("up") = py::make_tuple(0.0, 1.0, 0.0),
        py::kw_only(), py::arg("field_of_view") = PerspectiveCamera{}.field_of_view,
        py::arg("aspect") = 1.0, py::arg("near") = PerspectiveCamera{}.near,
        py::arg("far") = infinity,
        R"(The planes of what a camera sees, for Index.visible: (6, 4) float64, (5, 4) where far is infinite.

eye, forward, up are (3,), directions of any length; field_of_view in radians from bottom to top; aspect is width over
height; near and far lengths along forward.)");
    module.def(
        "orthographic",
        [](const py::object& eye, const py::object& forward, const py::object& up, double width,
           double height, double near, double far) {
            return planes_of(value_of(
                make_orthographic_volume({point_of(eye, "eye"), point_of(forward, "forward"),
                                          point_of(up, "up"), width, height, near, far})));
        },
        py::arg("eye"), py::arg("forward"), py::arg("up") = py::make_tuple(0.0, 1.0, 0.0),
        py::kw_only(), py::arg("width") = 2.0, py::arg("height") = 2.0, py::arg("near") = 0.0,
        py::arg("far") = infinity,
        "The planes of a box along `forward`, for Index.visible: as perspective().");
}

} // namespace proxima::python
