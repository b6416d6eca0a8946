// Each figure shows what it must: its parts against the library and against slow oracles, and the
// colours of those parts in the picture.
#include "proxima/octree/traverse.h"
#include "proxima/proximity/brute_force.h"
#include "proxima/query/build_ray_index.h"
#include "proxima/query/intersect_meshes.h"
#include "viewer/figures/figure_colors.h"
#include "viewer/figures/figure_pages.h"
#include "viewer/figures/minkowski_figures.h"
#include "viewer/figures/octree_figures.h"
#include "viewer/figures/query_figures.h"
#include "viewer/figures/ray_figures.h"
#include "viewer/figures/voronoi_figures.h"
#include "viewer/query_shapes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>

namespace proxima {
namespace {

using Pixel = std::array<std::uint8_t, 3>;

Pixel pixel_of(unsigned hex)
{
    return {static_cast<std::uint8_t>(hex >> 16U), static_cast<std::uint8_t>(hex >> 8U & 0xFFU),
            static_cast<std::uint8_t>(hex & 0xFFU)};
}

const ScenePanel& scene_of(const FigureContent& content, std::size_t panel = 0)
{
    return std::get<ScenePanel>(content.panels.at(panel));
}

Image picture_of(const ScenePanel& panel)
{
    return *make_software_renderer()->render(panel.scene, panel.camera, panel.size);
}

std::vector<const SceneSurface*> surfaces_named(const Scene& scene, const std::string& name)
{
    std::vector<const SceneSurface*> found;
    for (const SceneSurface& surface : scene.surfaces)
        if (surface.name == name) found.push_back(&surface);
    return found;
}

std::map<Pixel, int> pixels_by_color(const Image& image)
{
    std::map<Pixel, int> counts;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) ++counts[image.pixel(x, y)];
    return counts;
}

std::size_t boxes_of(const Figure& figure, unsigned color)
{
    return static_cast<std::size_t>(std::ranges::count(figure.boxes, color, &FigureBox::color));
}

std::size_t lines_of(const Figure& figure, unsigned color, double width)
{
    return static_cast<std::size_t>(
        std::ranges::count_if(figure.lines, [&](const FigureLine& line) {
            return line.color == color && line.width == width;
        }));
}

TEST(Figures, CirclesShowTheLeavesOfTheirQuadtrees)
{
    for (const Subdivision subdivision : {Subdivision::uniform, Subdivision::adaptive}) {
        const auto content = subdivision == Subdivision::uniform ? figure_2_3({}) : figure_2_4({});
        ASSERT_TRUE(content && content->drawing);
        std::array<std::size_t, 3> expected = {};
        for (const int depth : {2, 3, 4, 5}) {
            const auto tree = circle_quadtree(depth, subdivision);
            for (const QuadtreeLeaf& leaf : tree->leaves)
                ++expected[static_cast<std::size_t>(tree->type(leaf))];
        }
        const Figure& figure = *content->drawing;
        using namespace figure_colors;
        // One of each is the legend's.
        EXPECT_EQ(boxes_of(figure, outer_cell), expected[0] + 1);
        EXPECT_EQ(boxes_of(figure, inner_cell), expected[1] + 1);
        EXPECT_EQ(boxes_of(figure, boundary_cell), expected[2] + 1);
        // What the drawing holds is in the picture: cells far from lines have their colour.
        const Image image = figure_image(figure);
        std::size_t seen = 0;
        for (const FigureBox& box : figure.boxes) {
            if (box.color == faint) continue;
            const Vec2 center = 0.5 * (box.lower + box.upper);
            const bool near_line = std::ranges::any_of(figure.lines, [&](const FigureLine& line) {
                const Vec2 along = line.to - line.from;
                const double t = std::clamp((center - line.from).dot(along) /
                                                std::max(along.squaredNorm(), 1e-9),
                                            0.0, 1.0);
                return (line.from + t * along - center).norm() < 3.0;
            });
            if (near_line) continue;
            ++seen;
            EXPECT_EQ(image.pixel(static_cast<int>(center.x()), static_cast<int>(center.y())),
                      pixel_of(box.color));
        }
        EXPECT_GT(seen, 100U);
    }
}

TEST(Figures, PlanarSumsShowTheEdgesOfEachOperand)
{
    const auto sum = explained_planar_sum();
    ASSERT_TRUE(sum);
    EXPECT_EQ(sum->edges().size(), 7U);
    using namespace figure_colors;
    EXPECT_EQ(lines_of(*figure_3_4({})->drawing, red, 6.0), 3U);
    EXPECT_EQ(lines_of(*figure_3_6({})->drawing, blue, 6.0), 4U);
    EXPECT_EQ(lines_of(*figure_3_3({})->drawing, red, 6.0), 1U);
    EXPECT_EQ(lines_of(*figure_3_5({})->drawing, blue, 6.0), 1U);
    EXPECT_EQ(lines_of(*figure_3_2({})->drawing, ink, 4.0), sum->edges().size());
    // The bold outline is the convex hull of the points: none lies beyond a line of it.
    const auto figure = figure_3_2({});
    std::vector<FigureLine> hull;
    for (const FigureLine& line : figure->drawing->lines)
        if (line.color == ink && line.width == 4.0) hull.push_back(line);
    int corners = 0;
    for (const FigureLine& dot : figure->drawing->lines) {
        if (dot.from != dot.to || dot.color != ink) continue;
        ++corners;
        for (const FigureLine& line : hull) {
            // Pixels point down: the inside is to the right of a walk against the clock.
            const Vec2 along = (line.to - line.from).normalized();
            const Vec2 offset = dot.from - line.from;
            EXPECT_LE(along.x() * offset.y() - along.y() * offset.x(), 1e-6);
        }
    }
    EXPECT_EQ(corners, 12);
}

TEST(Figures, IndexTrackingShowsTheSameNumbersTwice)
{
    const auto content = figure_3_14({});
    ASSERT_TRUE(content);
    EXPECT_EQ(lines_of(*content->drawing, figure_colors::purple, 7.0), 2U);
    std::map<std::string, int> words;
    for (const FigureText& text : content->drawing->texts) ++words[text.text];
    for (int k = 0; k < 12; ++k) EXPECT_EQ(words[std::to_string(k)], 2) << k;
}

TEST(Figures, SumsInSpaceShowFacetsByOrigin)
{
    struct Expectation {
        Result<FigureContent> (*make)(const FigureContext&);
        std::size_t normals;
        int channel; // of the colour that stands out
    };
    for (const auto& [make, normals, channel] :
         {Expectation{figure_3_8, 6, 0}, Expectation{figure_3_9, 8, 2},
          Expectation{figure_3_10, 12, 1}}) {
        const auto content = make({});
        ASSERT_TRUE(content);
        const ScenePanel& panel = scene_of(*content);
        EXPECT_EQ(surfaces_named(panel.scene, "normal").size(), normals);
        const Image image = picture_of(panel);
        std::array<int, 3> strong = {};
        for (const auto& [color, count] : pixels_by_color(image)) {
            for (std::size_t k = 0; k < 3; ++k) {
                if (color[k] > 1.35 * color[(k + 1) % 3] && color[k] > 1.35 * color[(k + 2) % 3])
                    strong[k] += count;
            }
        }
        const int own = strong[static_cast<std::size_t>(channel)];
        EXPECT_GT(own, 20000);
        for (std::size_t k = 0; k < 3; ++k)
            if (static_cast<int>(k) != channel) {
                EXPECT_LT(strong[k], own / 10);
            }
    }
    const auto whole = figure_3_11({});
    ASSERT_TRUE(whole);
    EXPECT_EQ(surfaces_named(scene_of(*whole).scene, "normal").size(), 26U);
}

TEST(Figures, SumsOfTwoSizesHaveTheSameFacets)
{
    const auto content = figure_3_13({});
    ASSERT_TRUE(content);
    const auto facets = [&](std::size_t panel) {
        return surfaces_named(scene_of(*content, panel).scene, "facet");
    };
    ASSERT_EQ(facets(0).size(), facets(1).size());
    for (std::size_t i = 0; i < facets(0).size(); ++i)
        EXPECT_TRUE((facets(0)[i]->color == facets(1)[i]->color).all());
}

TEST(Figures, DegenerateTrianglesAreToldApartByTheirInside)
{
    const auto content = figure_3_15({});
    ASSERT_TRUE(content);
    const std::string& words = content->caption;
    EXPECT_NE(words.find("goes through the volume: touches the closed cube, meets its inside"),
              std::string::npos)
        << words;
    EXPECT_NE(words.find("lies in the face: touches the closed cube, misses its inside"),
              std::string::npos);
    EXPECT_NE(words.find("stays outside: touches the closed cube, misses its inside"),
              std::string::npos);
}

TEST(Figures, ListedCellsAreThoseThatTheRegionMeets)
{
    const auto shown = sphere_with_listed_feature({});
    ASSERT_TRUE(shown);
    const auto topology = build_topology(shown->mesh);
    std::set<std::uint64_t> listing;
    for (const ThesisCell& cell : shown->listing) listing.insert(cell.key.bits);
    // Points whose closest feature is the vertex lie in listed cells only.
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(-1.7, 1.7);
    std::set<std::uint64_t> met;
    for (int i = 0; i < 40000; ++i) {
        const Vec3 point{place(random), place(random), place(random)};
        const auto cell = shown->octree.locate(point);
        if (!cell || shown->octree.type(*cell) != CellClass::outer) continue;
        const auto closest = closest_feature_by_brute_force(shown->mesh, *topology, point);
        if (closest.feature != shown->feature) continue;
        EXPECT_TRUE(listing.contains(cell->key.bits));
        met.insert(cell->key.bits);
    }
    EXPECT_GT(met.size(), listing.size() / 3);
    const auto content = figure_4_2({});
    ASSERT_TRUE(content);
    EXPECT_EQ(surfaces_named(scene_of(*content, 1).scene, "cell").size(), listing.size());
}

TEST(Figures, VoronoiRegionsAreBoundedByTheirPlanes)
{
    struct Expectation {
        Result<FigureContent> (*make)(const FigureContext&);
        std::size_t planes;
        std::size_t rays;
    };
    for (const auto& [make, planes, rays] :
         {Expectation{figure_4_3, 3, 3}, Expectation{figure_4_4, 4, 4},
          Expectation{figure_4_5, 4, 4}}) {
        const auto content = make({});
        ASSERT_TRUE(content) << content.error().message;
        const Scene& scene = scene_of(*content).scene;
        EXPECT_EQ(surfaces_named(scene, "normal").size(), planes);
        EXPECT_EQ(surfaces_named(scene, "ray").size(), rays);
    }
    const auto bodies = figure_4_6({});
    ASSERT_TRUE(bodies);
    // The cube: 8 corners, 12 edges that are bent, 12 triangles.
    const Scene& cube = scene_of(*bodies, 0).scene;
    EXPECT_EQ(surfaces_named(cube, "vertex").size(), 8U);
    EXPECT_EQ(surfaces_named(cube, "edge").size(), 12U);
    EXPECT_EQ(surfaces_named(cube, "face").size(), 12U);
}

TEST(Figures, ObstructingFacetsAreThoseThatRaysLeadThrough)
{
    const auto content = figure_4_9({});
    ASSERT_TRUE(content) << content.error().message;
    for (std::size_t panel = 0; panel < 3; ++panel) {
        const Scene& scene = scene_of(*content, panel).scene;
        const auto normals = surfaces_named(scene, "normal");
        const auto rays = surfaces_named(scene, "ray");
        ASSERT_FALSE(normals.empty());
        ASSERT_FALSE(rays.empty());
        // Arrows begin with a vertex of the shaft and end at their tips.
        for (const SceneSurface* const normal : normals) {
            const auto direction = [](const SceneSurface& arrow) -> Vec3 {
                return arrow.positions[6] - arrow.positions[0];
            };
            const bool along_a_ray = std::ranges::any_of(rays, [&](const SceneSurface* ray) {
                return direction(*normal).dot(direction(*ray)) > 0.0;
            });
            EXPECT_TRUE(along_a_ray);
        }
    }
}

TEST(Figures, ListsGetShorterWithDepth)
{
    const auto content = figure_5_3({});
    ASSERT_TRUE(content && content->drawing);
    std::vector<double> means;
    for (std::size_t at = content->caption.find(": "); at != std::string::npos;
         at = content->caption.find(": ", at + 1)) {
        means.push_back(std::stod(content->caption.substr(at + 2)));
    }
    ASSERT_EQ(means.size(), 4U);
    EXPECT_TRUE(std::ranges::is_sorted(means, std::greater<>()));
}

/// Leaves in which a ray has a stretch of some length, by cutting it to each leaf's slabs.
std::set<std::uint64_t> leaves_on_ray(const LitCells& lit)
{
    struct Collector {
        const LitCells& lit;
        std::set<std::uint64_t>& keys;

        [[nodiscard]] bool should_enter(const Cell&) const { return true; }
        Flow visit_leaf(const Cell& cell, std::span<const TriangleId>)
        {
            const Box box = lit.octree.box(cell);
            double enter = lit.ray.t_min;
            double exit = lit.ray.t_max;
            for (int axis = 0; axis < 3; ++axis) {
                const double start = lit.ray.origin[axis];
                const double step = lit.ray.direction[axis];
                if (step == 0.0) {
                    if (start <= box.lower[axis] || start >= box.upper[axis]) exit = -1e300;
                    continue;
                }
                const double one = (box.lower[axis] - start) / step;
                const double other = (box.upper[axis] - start) / step;
                enter = std::max(enter, std::min(one, other));
                exit = std::min(exit, std::max(one, other));
            }
            if (exit - enter > 1e-9) keys.insert(cell.key.bits);
            return Flow::proceed;
        }
    };
    std::set<std::uint64_t> keys;
    traverse(lit.octree, Collector{lit, keys});
    return keys;
}

TEST(Figures, LitCellsAreThoseOfTheRayWithItsWeights)
{
    for (const bool fully : {true, false}) {
        const auto lit = fully ? fully_lit_cells({}) : variously_lit_cells({});
        const auto content = fully ? figure_5_5({}) : figure_5_6({});
        ASSERT_TRUE(lit && content);
        std::set<std::uint64_t> keys;
        for (const CellOnRay& cell : lit->cells) keys.insert(cell.cell.key.bits);
        EXPECT_EQ(keys, leaves_on_ray(*lit));
        EXPECT_GE(keys.size(), 8U);
        const ScenePanel& panel = scene_of(*content);
        const auto shown = surfaces_named(panel.scene, "cell");
        ASSERT_EQ(shown.size(), lit->cells.size());
        // The picture has the colour of each cell.
        const auto colors = pixels_by_color(picture_of(panel));
        for (std::size_t i = 0; i < shown.size(); ++i) {
            const double weight = lit->cells[i].penetration;
            if (fully) {
                EXPECT_NEAR(weight, 1.0, 1e-12);
            }
            const Color expected = intensity_color(weight);
            EXPECT_TRUE((shown[i]->color == expected).all());
            Canvas one(1, 1);
            one.fill_background(expected, expected);
            const auto found = colors.find(one.image().pixel(0, 0));
            EXPECT_TRUE(found != colors.end() && found->second > 50) << "cell " << i;
        }
    }
}

TEST(Figures, TheTouchedPlaceIsThatOfBruteForce)
{
    const auto touched = touched_place({});
    ASSERT_TRUE(touched);
    const auto topology = build_topology(touched->mesh);
    const auto closest = closest_feature_by_brute_force(touched->mesh, *topology, touched->cursor);
    EXPECT_EQ(touched->closest.feature, closest.feature);
    EXPECT_TRUE(touched->leaf.contains(touched->cursor));
    std::vector<TriangleId> around;
    const TriangleCorners own = touched->mesh.triangles()[closest.feature.id];
    for (std::uint32_t i = 0; i < touched->mesh.triangle_count(); ++i) {
        const bool shares = std::ranges::any_of(touched->mesh.triangles()[i], [&](auto corner) {
            return std::ranges::find(own, corner) != own.end();
        });
        if (shares && i != closest.feature.id) around.push_back(TriangleId{i});
    }
    EXPECT_EQ(touched->around, around);
    const auto content = figure_5_2({});
    ASSERT_TRUE(content) << content.error().message;
    const Scene& scene = scene_of(*content).scene;
    EXPECT_EQ(surfaces_named(scene, "closest").at(0)->triangles.size(), 1U);
    EXPECT_EQ(surfaces_named(scene, "around").at(0)->triangles.size(), around.size());
    EXPECT_EQ(surfaces_named(scene, "mesh").at(0)->triangles.size(),
              touched->mesh.triangle_count() - around.size() - 1);
    EXPECT_EQ(surfaces_named(scene, "leaf").size(), 1U);
}

TEST(Figures, YellowTrianglesAreAllThatCanIntersect)
{
    const auto spheres = meeting_spheres({});
    ASSERT_TRUE(spheres);
    const auto index_a = build_ray_index(spheres->octree_a, spheres->a);
    ASSERT_TRUE(index_a);
    const auto pairs = intersecting_pairs(*index_a, *index_a, spheres->pose_b);
    EXPECT_GT(pairs.size(), 50U);
    for (const TrianglePair& pair : pairs) {
        EXPECT_TRUE(std::ranges::binary_search(spheres->candidates.a, pair.a));
        EXPECT_TRUE(std::ranges::binary_search(spheres->candidates.b, pair.b));
    }
    const auto content = figure_5_4({});
    ASSERT_TRUE(content);
    const Scene& scene = scene_of(*content).scene;
    const auto yellow = surfaces_named(scene, "candidates");
    ASSERT_EQ(yellow.size(), 2U);
    EXPECT_EQ(yellow[0]->triangles.size(), spheres->candidates.a.size());
    EXPECT_EQ(yellow[1]->triangles.size(), spheres->candidates.b.size());
    for (const bool of_a : {true, false}) {
        std::set<std::uint64_t> keys;
        for (const LeafPair& pair : spheres->leaves) keys.insert((of_a ? pair.a : pair.b).key.bits);
        const auto lines =
            std::ranges::find(scene.lines, of_a ? "leaves of A" : "leaves of B", &SceneLines::name);
        ASSERT_NE(lines, scene.lines.end());
        EXPECT_EQ(lines->segments.size(), 12 * keys.size());
    }
}

TEST(Figures, CulledCellsAreOutsideOfAPlane)
{
    const auto ship = culled_ship({});
    ASSERT_TRUE(ship);
    struct Collector {
        const CulledShip& ship;
        std::set<std::uint64_t>& keys;
        std::set<TriangleId>& triangles;

        [[nodiscard]] bool should_enter(const Cell&) const { return true; }
        Flow visit_leaf(const Cell& cell, std::span<const TriangleId> held)
        {
            if (held.empty()) return Flow::proceed;
            const Box box = ship.octree.box(cell);
            for (const ViewPlane& plane : ship.volume.planes()) {
                double most = plane.offset;
                for (int k = 0; k < 3; ++k) {
                    most +=
                        std::max(plane.normal[k] * box.lower[k], plane.normal[k] * box.upper[k]);
                }
                if (most < 0.0) return Flow::proceed;
            }
            keys.insert(cell.key.bits);
            triangles.insert(held.begin(), held.end());
            return Flow::proceed;
        }
    };
    std::set<std::uint64_t> keys;
    std::set<TriangleId> triangles;
    traverse(ship->octree, Collector{*ship, keys, triangles});
    std::set<std::uint64_t> shown;
    for (const Cell& cell : ship->cells) shown.insert(cell.key.bits);
    EXPECT_EQ(shown, keys);
    EXPECT_EQ(ship->triangles, std::vector<TriangleId>(triangles.begin(), triangles.end()));
    const auto content = figure_5_7({});
    ASSERT_TRUE(content);
    const Scene& scene = scene_of(*content).scene;
    EXPECT_EQ(surfaces_named(scene, "visible").at(0)->triangles.size(), triangles.size());
    EXPECT_EQ(surfaces_named(scene, "culled").at(0)->triangles.size(),
              ship->mesh.triangle_count() - triangles.size());
}

TEST(Figures, AreNumberedOnceAndInOrder)
{
    std::set<std::string_view> numbers;
    for (const ThesisFigure& figure : thesis_figures())
        EXPECT_TRUE(numbers.insert(figure.number).second);
    EXPECT_EQ(numbers.size(), 37U);
    for (const MissingFigure& figure : missing_figures())
        EXPECT_TRUE(numbers.insert(figure.number).second);
    // 7 in chapter 2, 16 in 3, 9 in 4 and 8 in 5.
    EXPECT_EQ(numbers.size(), 40U);
}

} // namespace
} // namespace proxima
