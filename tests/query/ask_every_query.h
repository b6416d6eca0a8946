// Every query about an index, for indexes that may be anybody's: what comes back must name what the
// index has, and nothing may read beyond its arrays. Answers are not compared: a forgery may hold wrong ones.
#pragma once

#include "base/check.h"
#include "index/index_parts.h"
#include "proxima/cast_ray.h"
#include "proxima/closest_feature.h"
#include "proxima/cull.h"
#include "proxima/distance_field.h"
#include "proxima/intersect_meshes.h"
#include "proxima/mesh_deviation.h"
#include "proxima/mesh_distance.h"
#include "proxima/mesh_index.h"
#include "proxima/neighbourhood.h"
#include "proxima/scene.h"
#include "proxima/signed_distance.h"
#include "proxima/time_of_contact.h"
#include "proxima/view_volume.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace proxima::testing {

class EveryQuery {
public:
    /// `seed`: of the points, rays and poses that it is asked about.
    EveryQuery(const MeshIndex& index, std::uint64_t seed) : index_(index), random_(seed)
    {
        std::uniform_real_distribution<double> reach(-1.2, 1.2);
        for (int i = 0; i < 16; ++i) {
            const Vec3 from_center{reach(random_), reach(random_), reach(random_)};
            points_.emplace_back(index.parts().center() + size() * from_center);
        }
        for (std::size_t i = 0; i < 16; ++i)
            rays_.push_back({points_[i], points_[(i + 1) % 16] - points_[i]});
    }

    void ask()
    {
        ask_points();
        ask_rays();
        ask_neighbours();
        ask_views();
        ask_pairs();
        ask_surfaces();
        ask_scene();
    }

private:
    [[nodiscard]] double size() const noexcept { return index_.parts().unscale(); }

    void expect_exists(TriangleId id) const
    {
        PROXIMA_CHECK_LT(to_index(id), index_.triangle_count());
    }
    void expect_exists(const ClosestFeature& found) const
    {
        const std::array<std::size_t, 3> counts = {index_.vertex_count(), index_.edge_count(),
                                                   index_.triangle_count()};
        PROXIMA_CHECK_LT(found.feature.id, counts[static_cast<std::size_t>(found.feature.kind)]);
        expect_exists(found.triangle);
    }

    void ask_points()
    {
        std::vector<ClosestFeature> answers(points_.size());
        PROXIMA_CHECK(
            closest_features(index_, points_, {.answers = answers}, {.execution = alone_}));
        for (const ClosestFeature& found : answers) expect_exists(found);
        for (const Vec3& p : points_) {
            const auto found = closest_feature(index_, p);
            PROXIMA_CHECK(found.has_value());
            expect_exists(*found);
            PROXIMA_CHECK_EQ(signed_distance(index_, p).has_value(), index_.has_signs());
        }
        PointGrid grid;
        grid.size = {5, 4, 3};
        grid.spacing = size() / 2;
        grid.origin = index_.parts().center() - Vec3::Constant(size());
        std::vector<double> distances(grid.point_count());
        std::vector<Vec3> gradients(grid.point_count());
        (void)distance_field(index_, grid, {.distances = distances, .gradients = gradients},
                             {.execution = alone_});
    }

    void ask_rays()
    {
        std::vector<std::optional<RayHit>> hits(rays_.size());
        (void)closest_hits(index_, rays_, hits, {.execution = alone_});
        for (const auto& hit : hits)
            if (hit) expect_exists(hit->triangle);
        for (const Ray& ray : rays_) {
            for (const RayHit& hit : all_hits(index_, ray)) expect_exists(hit.triangle);
            if (const auto hit = closest_hit(index_, ray)) expect_exists(hit->triangle);
            (void)any_hit(index_, ray);
        }
    }

    void ask_neighbours()
    {
        std::array<TriangleId, 8> triangles;
        std::array<NearTriangle, 8> nearest;
        std::array<NearestFeature, 8> features;
        for (const Vec3& p : points_) {
            const Neighbourhood in_ball = collect_triangles(index_, p, size() / 2, triangles);
            for (std::size_t i = 0; i < in_ball.written; ++i) expect_exists(triangles[i]);
            const Vec3 reach = Vec3::Constant(size() / 2);
            const Neighbourhood in_box =
                collect_triangles(index_, Box{p - reach, p + reach}, triangles);
            for (std::size_t i = 0; i < in_box.written; ++i) expect_exists(triangles[i]);
            const Neighbourhood near = collect_nearest(index_, p, nearest);
            for (std::size_t i = 0; i < near.written; ++i) expect_exists(nearest[i].triangle);
            (void)collect_features(index_, p, size() / 2, features);
        }
    }

    void ask_views()
    {
        for (const CullMode mode : {CullMode::conservative, CullMode::exact}) {
            for (std::size_t i = 0; i < 4; ++i) {
                const auto volume = make_perspective_volume(
                    {.eye = points_[i], .forward = rays_[i].direction, .near = size() / 100});
                if (!volume) continue;
                for (const TriangleId id : visible_triangles(index_, *volume, mode))
                    expect_exists(id);
            }
        }
    }

    void ask_pairs()
    {
        const RigidTransform moved = {Mat3::Identity(), 0.3 * (points_[0] - points_[1])};
        std::array<TrianglePair, 64> pairs;
        const std::size_t count = intersecting_pairs(index_, index_, moved, pairs);
        for (std::size_t i = 0; i < std::min(count, pairs.size()); ++i) {
            expect_exists(pairs[i].a);
            expect_exists(pairs[i].b);
        }
        (void)meshes_intersect(index_, index_, moved);
        if (const auto meeting = find_meeting(index_, index_, moved)) {
            expect_exists(meeting->triangle_a);
            expect_exists(meeting->triangle_b);
        }
        (void)intersection_contour(index_, index_, moved);
        const RigidTransform apart = {Mat3::Identity(), Vec3(4 * size(), 0, 0)};
        for (const RigidTransform& pose : {moved, apart}) {
            if (const auto near = mesh_distance(index_, index_, pose)) {
                expect_exists(near->triangle_a);
                expect_exists(near->triangle_b);
            }
        }
        const RigidMotion motion = {.start = apart,
                                    .center = index_.parts().center(),
                                    .displacement = Vec3(-4 * size(), 0, 0),
                                    .turn = Vec3(0, 0.5, 1)};
        if (check_motion(motion)) {
            const auto time =
                time_of_contact(index_, index_, motion, {.max_steps = 1000, .execution = alone_});
            if (time) expect_exists(time->triangle_a);
        }
        if (const auto found =
                find_self_intersections(index_, {.max_pairs = 100, .execution = alone_})) {
            for (const TrianglePair& pair : found->pairs) {
                expect_exists(pair.a);
                expect_exists(pair.b);
            }
        }
    }

    void ask_surfaces()
    {
        (void)greatest_deviation(index_, index_,
                                 {.max_places = 2, .max_splits = 100, .execution = alone_});
        (void)mean_deviation(index_, index_, {.max_splits = 100, .execution = alone_});
        if (const auto enclosure = build_enclosure(index_, {alone_}))
            (void)encloses(*enclosure, {}, points_[0]);
    }

    void ask_scene()
    {
        const std::array<MeshIndex, 1> shapes = {index_};
        const std::array<Instance, 2> instances = {
            Instance{}, Instance{.pose = {Mat3::Identity(), Vec3(size(), 0, 0)}}};
        const auto scene = build_scene(shapes, instances, {alone_});
        if (!scene) return;
        for (std::size_t i = 0; i < 4; ++i) {
            if (const auto hit = closest_hit(*scene, rays_[i])) expect_exists(hit->hit.triangle);
            if (const auto found = closest_feature(*scene, points_[i]))
                expect_exists(found->closest);
        }
    }

    const Execution alone_ = {.threads = {1}};

    const MeshIndex& index_;
    std::mt19937_64 random_;
    std::vector<Vec3> points_;
    std::vector<Ray> rays_;
};

} // namespace proxima::testing
