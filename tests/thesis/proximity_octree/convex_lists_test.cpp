// On convex meshes two constructions of the same lists: the thesis's, by Minkowski sums of exterior
// Voronoi regions with the cell, and the general one, by local regions and certificates.
#include "index/index_parts.h"
#include "index/listed_index.h"
#include "index/lists/cell_cover.h"
#include "index/lists/domination.h"
#include "index/lists/local_feature_names.h"
#include "index/lists/local_region.h"
#include "index/lists/proximity_cells.h"
#include "index/lists/proximity_lists.h"
#include "index/lists/region_oracle.h"
#include "index/lists/root_frame.h"
#include "thesis/proximity_octree/convex_meshes.h"
#include "thesis/proximity_octree/convex_surface.h"
#include "thesis/proximity_octree/list_statistics.h"
#include "thesis/proximity_octree/thesis_proximity_octree.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <random>

namespace proxima::convex_lists_test {
namespace {

/// A cell with the places of its local features.
struct GeneralCell {
    CellKey key;
    FrameCell cube;
    std::vector<std::uint32_t> features;
};

/// The general construction down to cells of one depth, none of them ended early.
class GeneralCells {
public:
    GeneralCells(const TriangleMesh& mesh, const Topology& topology, double margin)
        : frame_(make_root_frame(bounding_box(mesh), margin)), order_(mesh.triangle_count())
    {
        for (std::uint32_t i = 0; i < order_.size(); ++i) order_[i] = TriangleId{i};
        features_ = collect_local_features(mesh, topology, order_, frame_, nullptr).value();
        names_ = testing::names_of(features_, mesh, topology, order_);
        level_.resize(1);
        level_[0].cube.half = static_cast<float>(frame_.frame_half());
        level_[0].features.resize(features_.features.size());
        std::iota(level_[0].features.begin(), level_[0].features.end(), 0U);
    }

    void split_all()
    {
        std::vector<GeneralCell> next;
        std::vector<std::uint8_t> masks;
        for (const GeneralCell& cell : level_) {
            masks.resize(cell.features.size());
            find_children_in_reach(features_, cell.features, cell.cube, masks.data());
            for (int octant = 0; octant < 8; ++octant) {
                GeneralCell& one = next.emplace_back();
                one.key = child(cell.key, octant);
                one.cube = child(cell.cube, octant);
                for (std::size_t k = 0; k < masks.size(); ++k)
                    if ((masks[k] >> octant & 1) != 0) one.features.push_back(cell.features[k]);
                one.features.resize(drop_dominated(features_, one.features.data(),
                                                   one.features.size(), one.cube, scratch_));
            }
        }
        level_ = std::move(next);
    }

    [[nodiscard]] const std::vector<GeneralCell>& cells() const { return level_; }
    [[nodiscard]] const LocalFeatures& features() const { return features_; }
    [[nodiscard]] const Feature& name(std::uint32_t place) const { return names_[place]; }
    [[nodiscard]] const RootFrame& frame() const { return frame_; }

    [[nodiscard]] std::vector<Feature> list(const GeneralCell& cell) const
    {
        std::vector<Feature> list;
        for (const std::uint32_t place : cell.features) list.push_back(names_[place]);
        std::ranges::sort(list);
        return list;
    }

private:
    RootFrame frame_;
    std::vector<TriangleId> order_;
    LocalFeatures features_;
    std::vector<Feature> names_;
    std::vector<GeneralCell> level_;
    DominationScratch scratch_;
};

std::vector<Feature> list_of(const ThesisProximityOctree& octree, const ThesisCell& cell)
{
    std::vector<Feature> list;
    for (const FeatureKind kind : {FeatureKind::vertex, FeatureKind::edge, FeatureKind::face})
        for (const std::uint32_t id : octree.closest(cell, kind)) list.push_back({kind, id});
    std::ranges::sort(list);
    return list;
}

/// Cells of the thesis's octree of equal depth, by key.
std::map<CellKey, ThesisCell> cells_of(const ThesisProximityOctree& octree)
{
    std::map<CellKey, ThesisCell> cells;
    octree.for_each_leaf([&](const ThesisCell& cell) { cells.emplace(cell.key, cell); });
    return cells;
}

ThesisProximityOctree uniform_thesis(const TriangleMesh& mesh, const Topology& topology, int depth)
{
    return build_thesis_proximity_octree(mesh, topology,
                                         {.max_depth = depth, .thresholds = {0, 0, 0}})
        .value();
}

TEST(ConvexLists, ContainTheListsOfTheThesis)
{
    std::size_t compared = 0;
    for (const auto& [name, mesh] : test::convex_meshes()) {
        SCOPED_TRACE(name);
        const Topology topology = *build_topology(mesh);
        GeneralCells general(mesh, topology, 0.5);
        for (int depth = 1; depth <= 4; ++depth) {
            general.split_all();
            const auto thesis = uniform_thesis(mesh, topology, depth);
            const auto cells = cells_of(thesis);
            for (const GeneralCell& cell : general.cells()) {
                const auto found = cells.find(cell.key);
                if (found == cells.end()) continue; // within an inner cell
                const Box box = thesis.box(found->second);
                const Vec3 center =
                    general.frame().center +
                    Eigen::Map<const Eigen::Vector3f>(cell.cube.center).cast<double>() /
                        general.frame().scale;
                // The builder's cells are floats.
                ASSERT_LT((box.center() - center).norm(),
                          0x1p-22 * general.frame().half + 1e-15 * center.norm());
                const auto wanted = list_of(thesis, found->second);
                const auto list = general.list(cell);
                ASSERT_TRUE(std::ranges::includes(list, wanted)) << "depth " << depth;
                compared += wanted.size();
            }
        }
    }
    EXPECT_GT(compared, 200000U);
}

TEST(ConvexLists, ContainLittleBeyondTheListsOfTheThesis)
{
    std::mt19937 random(31);
    std::size_t same = 0;
    std::size_t behind = 0;
    std::size_t more = 0;
    for (const auto& [name, mesh] : test::convex_meshes()) {
        if (name == "plate" || name == "needle") continue; // their regions meet within rounding
        SCOPED_TRACE(name);
        const Topology topology = *build_topology(mesh);
        GeneralCells general(mesh, topology, 0.5);
        const int depth = 4;
        for (int i = 0; i < depth; ++i) general.split_all();
        const auto thesis = uniform_thesis(mesh, topology, depth);
        const MeshSphere sphere = circumscribed_sphere(mesh);
        // The margins of the general construction, in the mesh's unit, with room for corners.
        const double slack = 0x1p-16 / general.frame().scale;
        for (const auto& [key, at] : cells_of(thesis)) {
            const Box box = thesis.box(at);
            if (!sphere.is_outside(box) || random() % 4 != 0) continue;
            const auto cell = std::ranges::find(general.cells(), key, &GeneralCell::key);
            ASSERT_NE(cell, general.cells().end());
            const auto listed = list_of(thesis, at);
            for (const Feature& feature : general.list(*cell)) {
                if (std::ranges::binary_search(listed, feature)) {
                    ++same;
                    continue;
                }
                auto planes = oracle::region_planes(mesh, topology, feature);
                if (oracle::meets_box(planes, box, slack)) continue; // within the margins
                // The region of a face goes both ways; what lies behind it is dropped by other
                // means.
                if (feature.kind == FeatureKind::face) {
                    oracle::QuadPlane& side = planes.front();
                    side = {oracle::Quad(-1) * side.normal, oracle::Quad(-1) * side.offset};
                    if (oracle::meets_box(planes, box, slack)) {
                        ++behind;
                        continue;
                    }
                }
                ++more;
            }
        }
    }
    EXPECT_GT(same, 5000U);
    EXPECT_LT(behind, same / 1000);
    EXPECT_EQ(more, 0U);
}

CellKey key_of(const ProximityCell& cell)
{
    CellKey key;
    for (int level = cell.depth - 1; level >= 0; --level) {
        int octant = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            octant |= static_cast<int>(cell.at[axis] >> level & 1U) << axis;
        key = child(key, octant);
    }
    return key;
}

std::vector<TriangleId> triangles_with(const Topology& topology, const Feature& feature)
{
    if (feature.kind == FeatureKind::face) return {TriangleId{feature.id}};
    const auto triangles = feature.kind == FeatureKind::vertex
                               ? topology.triangles(VertexId{feature.id})
                               : topology.triangles(EdgeId{feature.id});
    return {triangles.begin(), triangles.end()};
}

// What queries see: triangles that hold all that the thesis lists in the same cell.
TEST(ConvexLists, OfLeavesContainThoseOfTheThesis)
{
    constexpr int max_depth = 4;
    std::size_t leaves = 0;
    std::size_t features = 0;
    for (const auto& [name, mesh] : test::convex_meshes()) {
        SCOPED_TRACE(name);
        const Topology topology = *build_topology(mesh);
        std::vector<std::map<CellKey, ThesisCell>> cells;
        std::vector<ThesisProximityOctree> thesis;
        for (int depth = 0; depth <= max_depth; ++depth) {
            thesis.push_back(uniform_thesis(mesh, topology, depth));
            cells.push_back(cells_of(thesis.back()));
        }
        const auto octree = testing::listed_index(
            mesh, {.list_bytes = 65536 + 20000 * mesh.triangle_count(), .max_depth = max_depth});
        ASSERT_TRUE(octree) << describe(octree.error());
        const ProximityArrays& arrays = octree->parts().lists()->arrays();
        const auto triangle_of = [&](std::uint32_t rank) { return octree->ids()[rank]; };
        std::vector<std::uint32_t> ranks;
        std::vector<ProximityCell> pending = {{root_word(arrays).value(), 0, {}}};
        while (!pending.empty()) {
            const ProximityCell cell = pending.back();
            pending.pop_back();
            if (!proximity_word::is_leaf(cell.word)) {
                for (std::uint32_t octant = 0; octant < 8; ++octant)
                    pending.push_back(child(arrays, cell, octant));
                continue;
            }
            read_list(arrays, cell.word, ranks);
            const auto level = static_cast<std::size_t>(cell.depth);
            const auto found = cells[level].find(key_of(cell));
            if (ranks.empty() || found == cells[level].end()) continue; // no list, or inside
            ++leaves;
            std::vector<TriangleId> listed;
            for (const std::uint32_t rank : ranks) listed.push_back(triangle_of(rank));
            std::ranges::sort(listed);
            for (const Feature& feature : list_of(thesis[level], found->second)) {
                ++features;
                EXPECT_TRUE(std::ranges::any_of(
                    triangles_with(topology, feature),
                    [&](TriangleId t) { return std::ranges::binary_search(listed, t); }))
                    << "depth " << level;
            }
        }
    }
    EXPECT_GT(leaves, 1000U);
    EXPECT_GT(features, 10000U);
}

// Thesis 5.1.2, figure 5.3: the general construction comes to the figures of the thesis's.
TEST(ConvexLists, ReproduceTheListLengthsOfFigure53)
{
    const TriangleMesh mesh = make_sphere(50, 50);
    const Topology topology = *build_topology(mesh);
    const MeshSphere sphere = circumscribed_sphere(mesh);
    const ConvexSurface surface = check_convex_surface(mesh, topology).value();
    GeneralCells general(mesh, topology, 0.5);
    struct Expected {
        int depth;
        double features;
        double cover;
    };
    RankSet taken;
    std::vector<std::uint32_t> cover;
    for (const Expected& expected :
         {Expected{3, 97.72, 39.90}, Expected{4, 32.66, 13.83}, Expected{5, 12.15, 5.34}}) {
        while (depth(general.cells().front().key) < expected.depth) general.split_all();
        const auto thesis = uniform_thesis(mesh, topology, expected.depth);
        const auto cells = cells_of(thesis);
        std::vector<std::uint32_t> lengths;
        std::vector<std::uint32_t> covers;
        std::vector<std::uint32_t> wanted;
        for (const GeneralCell& cell : general.cells()) {
            const auto found = cells.find(cell.key);
            if (found == cells.end() || !sphere.is_outside(thesis.box(found->second))) continue;
            // Edges between coplanar faces have flat regions; the thesis leaves them out.
            std::vector<std::uint32_t> list;
            std::ranges::copy_if(cell.features, std::back_inserter(list), [&](std::uint32_t place) {
                const Feature& feature = general.name(place);
                return feature.kind != FeatureKind::edge ||
                       surface.folds[feature.id] == EdgeFold::ridge;
            });
            lengths.push_back(static_cast<std::uint32_t>(list.size()));
            cover_features(general.features(), list, taken, cover);
            covers.push_back(static_cast<std::uint32_t>(cover.size()));
            wanted.push_back(thesis.list_length(found->second));
        }
        EXPECT_EQ(outer_list_lengths(thesis, sphere).size(), lengths.size());
        const double ours = list_statistics(lengths).mean;
        const double thesiss = list_statistics(wanted).mean;
        EXPECT_NEAR(thesiss, expected.features, 0.005);
        EXPECT_NEAR(ours, expected.features, 0.005);
        EXPECT_NEAR(list_statistics(covers).mean, expected.cover, 0.005);
    }
}

} // namespace
} // namespace proxima::convex_lists_test
