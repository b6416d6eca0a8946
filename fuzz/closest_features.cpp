// Closest features of points to any triangles, by the index and by its lists, against the distances
// to all features: the same bits.
#include "base/check.h"
#include "decoded_mesh.h"
#include "proxima/closest_feature.h"
#include "proxima/mesh_index.h"
#include "proxima/topology.h"
#include "query/closest/brute_force.h"
#include "slow_answers.h"

#include <cstddef>
#include <cstdint>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    using namespace proxima;
    fuzz::Bytes bytes({data, size});
    const bool has_lists = bytes.next() % 8 == 0;
    const fuzz::PositionCode code(bytes);
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code);
    const Topology topology = build_topology(mesh).value();
    const Execution alone{.threads = {1}};
    MeshIndex index = build_mesh_index(mesh, {.execution = alone}).value();
    if (has_lists) {
        const ListOptions small{.list_bytes = 20'000, .max_depth = 6, .execution = alone};
        if (auto listed = with_lists(index, small)) index = *listed;
    }
    std::vector<Vec3> points;
    do {
        points.push_back(fuzz::decode_point(bytes, code, mesh));
    } while (bytes.left() > 0 && points.size() < 16);
    std::vector<ClosestFeature> answers(points.size());
    PROXIMA_CHECK(
        closest_features(index, points, {.answers = answers}, {.execution = alone}).has_value());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const ClosestFeature truth = closest_feature_by_brute_force(mesh, topology, points[i]);
        const auto found = closest_feature(index, points[i]);
        PROXIMA_CHECK(found.has_value());
        fuzz::expect_same(*found, truth);
        fuzz::expect_same(answers[i], truth);
    }
    return 0;
}
