// What panels show without a window, held against slow oracles.
#include "code_of.h"
#include "folder_test.h"
#include "lab/simulated_hand.h"
#include "proxima/cast_ray.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/octree.h"
#include "query/closest/brute_force.h"
#include "viewer/panels/panels.h"
#include "viewer/shown_viewer.h"
#include "viewer/view_models.h"

#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <optional>
#include <set>
#include <thread>

namespace proxima::panels_test {
namespace {

/// How many edges the leaves of some classes have. Leaves of one size share them.
std::size_t distinct_edges(const Octree& octree, const std::vector<CellClass>& classes)
{
    // Its depth, its axis and the cell of that depth whose lower corner it begins at.
    using Edge = std::array<std::uint32_t, 5>;
    struct Collect {
        const std::vector<CellClass>& classes;
        std::set<Edge>& edges;
        [[nodiscard]] bool should_enter(const Cell& /*cell*/) const { return true; }
        [[nodiscard]] Flow visit_leaf(const Cell& cell, std::span<const TriangleId> /*ids*/) const
        {
            if (std::ranges::find(classes, cell.type) == classes.end()) return Flow::proceed;
            const auto at = cell_coordinates(cell.key);
            for (std::uint32_t axis = 0; axis < 3; ++axis) {
                for (const std::uint32_t beside : {0U, 1U, 2U, 3U}) {
                    Edge edge = {static_cast<std::uint32_t>(depth(cell.key)), axis, at[0], at[1],
                                 at[2]};
                    edge[2 + (axis + 1) % 3] += beside & 1U;
                    edge[2 + (axis + 2) % 3] += beside >> 1U;
                    edges.insert(edge);
                }
            }
            return Flow::proceed;
        }
    };
    std::set<Edge> edges;
    traverse(octree, Collect{classes, edges});
    return edges.size();
}

/// The force of a hand that wants to be so far below the surface, N: the hand's spring and the
/// wall's in a row. Shown with three digits after the point.
double force_at_rest(const ViewModel& model, double depth)
{
    const double hand = HandModel{}.hand_stiffness;
    const double wall = 400; // as the panel offers it at first
    const double radius = find_device("touch")->workspace_radius;
    const double metres = depth / fit_workspace(model.box, radius).units_per_metre;
    return metres * hand * wall / (hand + wall);
}

TEST(Panels, PanelsOfDetailsStartWithACloseUp)
{
    Shown shown({"icosphere:5"}, "model");
    const double distance = shown.viewer.camera().distance;
    // The widest close-up shows 12 % of the model's diagonal to each side: a cube in a ball of
    // sqrt(3) times that. The model is all but a ball of radius 1.
    const double ball = std::sqrt(3) * 0.12 * shown.viewer.models()[0]->box.extent().norm();
    for (const char* const panel : {"panel=closest", "panel=voronoi", "panel=touch"}) {
        shown.set({panel});
        EXPECT_LT(shown.viewer.camera().distance, 1.01 * ball * distance) << panel;
        // What it is about is in the middle of the picture.
        const View view(shown.viewer.camera(), shown_size);
        const ScreenPoint at = view.project(shown.viewer.handles().front());
        EXPECT_NEAR(at.x, 0.5 * shown_size.width, 1e-6) << panel;
        EXPECT_NEAR(at.y, 0.5 * shown_size.height, 1e-6) << panel;
    }
    const double pressed = 0.08 * shown.viewer.models()[0]->box.extent().norm();
    EXPECT_NEAR(shown.number("force"), force_at_rest(*shown.viewer.models()[0], pressed), 1e-3)
        << "it is touched at once";
    shown.viewer.frame_all();
    EXPECT_EQ(shown.viewer.camera().distance, distance);
}

/// A thick tube along y, which a camera in front looks into.
void write_tube(const std::filesystem::path& path)
{
    constexpr int around = 48;
    constexpr std::array<std::array<double, 2>, 4> profile = {
        {{1.0, -0.8}, {1.0, 0.8}, {0.6, 0.8}, {0.6, -0.8}}};
    std::ofstream file(path);
    for (const auto& [radius, y] : profile) {
        for (int i = 0; i < around; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / around;
            file << "v " << radius * std::cos(angle) << ' ' << radius * std::sin(angle) << ' ' << y
                 << '\n';
        }
    }
    for (int ring = 0; ring < 4; ++ring) {
        for (int i = 0; i < around; ++i) {
            const int a = around * ring + i + 1;
            const int b = around * ring + (i + 1) % around + 1;
            const int above = around * ((ring + 1) % 4) - around * ring;
            file << "f " << a << ' ' << b << ' ' << b + above << '\n';
            file << "f " << a << ' ' << b + above << ' ' << a + above << '\n';
        }
    }
}

using PanelsOfFiles = FolderTest;

TEST_F(PanelsOfFiles, PanelsOfDetailsBeginWhereTheEyeSees)
{
    const std::string tube = path("tube.obj").string();
    write_tube(tube);
    for (const std::string& name :
         {tube, std::string("torus:48x24"), std::string("spaceship:3000")}) {
        for (const char* const panel : {"closest", "voronoi"}) {
            const Shown shown({name}, panel);
            const ViewModel& model = *shown.viewer.models().front();
            const View view(shown.viewer.camera(), shown_size);
            const Vec3 point = shown.viewer.handles().front();
            EXPECT_FALSE(any_hit(model.rays, {.origin = point, .direction = view.eye() - point}))
                << name << ' ' << panel << ": something hides the ring";
        }
        const Shown shown({name}, "touch");
        EXPECT_NE(shown.fact("contact"), "free") << name;
    }
    // Not in the bore.
    for (const char* const panel : {"closest", "voronoi"}) {
        const Shown shown({tube}, panel);
        const Vec3 point = shown.viewer.handles().front();
        EXPECT_GT(std::hypot(point.x(), point.y()), 0.6) << panel;
    }
    const Shown touched({tube}, "touch");
    for (const SceneSurface& surface : touched.scene().surfaces) {
        if (surface.name != "proxy") continue;
        Box box;
        for (const Vec3& position : surface.positions) box.extend(position);
        EXPECT_GT(std::hypot(box.center().x(), box.center().y()), 0.65);
    }
}

TEST(Panels, IntersectionPanelBeginsAtTheContact)
{
    Shown shown({"icosphere:4", "icosphere:2"}, "intersection");
    const View view(shown.viewer.camera(), shown_size);
    Eigen::AlignedBox2d seen;
    for (const SceneLines& lines : shown.scene().lines) {
        if (lines.name != "contour") continue;
        for (const auto& segment : lines.segments) {
            for (const Vec3& end : segment) {
                const ScreenPoint at = view.project(end);
                seen.extend(Vec2(at.x, at.y));
            }
        }
    }
    ASSERT_FALSE(seen.isEmpty());
    EXPECT_GT(seen.min().minCoeff(), 0.0);
    EXPECT_LT(seen.max().x(), shown_size.width);
    EXPECT_LT(seen.max().y(), shown_size.height);
    EXPECT_GT(seen.sizes().y(), 0.4 * shown_size.height);
}

/// The legend's colour for these words.
std::optional<unsigned> color_in_legend(const Shown& shown, std::string_view words)
{
    const auto& entries = shown.viewer.legend().entries;
    const auto found = std::ranges::find(entries, words, &LegendEntry::text);
    return found == entries.end() ? std::nullopt : std::optional(found->color);
}

TEST(Panels, LegendsHaveTheColoursOfThePicture)
{
    Shown shown({"icosphere:3"}, "octree", {"colour by=count"});
    std::set<unsigned> drawn;
    for (const SceneLines& lines : shown.scene().lines)
        if (lines.name == "cells") drawn.insert(hex_of(lines.color));
    std::set<unsigned> listed;
    for (const LegendEntry& entry : shown.viewer.legend().entries) listed.insert(entry.color);
    EXPECT_EQ(listed, drawn);
    EXPECT_EQ(shown.viewer.legend().title, "triangles in a leaf");
    shown.set({"panel=closest"});
    for (const SceneSurface& surface : shown.scene().surfaces) {
        if (surface.name == "patch") {
            EXPECT_EQ(color_in_legend(shown, "triangles round it"), hex_of(surface.color));
        }
    }
    for (const char* const panel :
         {"minkowski", "voronoi", "rays", "culling", "intersection", "touch"}) {
        shown.set({std::string("panel=") + panel});
        EXPECT_GE(shown.viewer.legend().entries.size(), 3U) << panel;
    }
    shown.set({"panel=model"});
    EXPECT_TRUE(shown.viewer.legend().entries.empty()) << "it has no flaws";
}

TEST(Panels, SettingsNameTheConditionThatTheyNeed)
{
    Viewer viewer;
    ASSERT_TRUE(viewer.choose_panel("octree"));
    const auto offer = [&](Controls& controls) { viewer.offer(controls); };
    const std::vector<ControlDescription> controls = describe_controls(offer);
    EXPECT_NE(std::ranges::find(controls, "cut at = 0 (-1 to 1), needs cut plane=on",
                                &ControlDescription::text),
              controls.end());
    const Status refused = apply_settings({"cut at=0.5"}, offer);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("needs cut plane=on"), std::string::npos);
    EXPECT_TRUE(apply_settings({"cut at=0.5", "cut plane=on"}, offer));
}

TEST(Panels, CullingPanelHasItsVolumeInThePicture)
{
    const Shown shown({"icosphere:4"}, "culling");
    const View view(shown.viewer.camera(), shown_size);
    EXPECT_GE(shown.segments("volume"), 12U);
    for (const SceneLines& lines : shown.scene().lines) {
        if (lines.name != "volume") continue;
        for (const auto& segment : lines.segments) {
            for (const Vec3& end : segment) {
                const ScreenPoint at = view.project(end);
                EXPECT_TRUE(at.x > 0 && at.x < shown_size.width && at.y > 0 &&
                            at.y < shown_size.height);
            }
        }
    }
}

/// As the command line shows it: settings come before models.
void open(Viewer& viewer, std::string_view panel, const std::vector<std::string>& settings,
          std::vector<std::string> models)
{
    viewer.resize(shown_size);
    ASSERT_TRUE(viewer.choose_panel(panel));
    ASSERT_TRUE(apply_settings(settings, [&](Controls& controls) { viewer.offer(controls); }));
    viewer.open(std::move(models));
    ASSERT_TRUE(viewer.finish());
}

TEST(Panels, CellsAndRaysThatStandOutAreInThePicture)
{
    const Shown rays({"spaceship:3000"}, "rays");
    EXPECT_TRUE(rays.is_all_in_view());
    Shown shown({"spaceship:3000"}, "octree");
    shown.set({"depth=3", "outer=on"});
    EXPECT_FALSE(shown.is_all_in_view()) << "the camera stays where it is";
    shown.viewer.frame_all();
    EXPECT_TRUE(shown.is_all_in_view());
    Viewer at_first;
    open(at_first, "octree", {"depth=3", "outer=on"}, {"spaceship:3000"});
    EXPECT_EQ(at_first.camera().distance, shown.viewer.camera().distance);
}

TEST(Panels, OneCoordinateOfAPointCanBeSet)
{
    const Shown usual({"icosphere:3"}, "closest");
    const Vec3 placed = usual.viewer.handles().front();
    Viewer viewer;
    open(viewer, "closest", {"cursor x=0.3"}, {"icosphere:3"});
    EXPECT_EQ(viewer.handles().front(), Vec3(0.3, placed.y(), placed.z()));
    // Once it is seen, a person who moves it along one axis leaves it on the others.
    Shown shown({"icosphere:3"}, "closest", {"cursor x=0.3"});
    shown.viewer.open({"torus:24x12"});
    ASSERT_TRUE(shown.viewer.finish());
    EXPECT_EQ(shown.viewer.handles().front(), Vec3(0.3, placed.y(), placed.z()));
}

TEST(Panels, GoByTheDirectionUpThatIsAskedFor)
{
    for (const Vec3& up : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY())}) {
        Viewer viewer({.camera = {.up = up}});
        open(viewer, "rays", {}, {"cube"});
        EXPECT_EQ(viewer.models().front()->up, up);
        EXPECT_EQ(viewer.camera().up, up);
        const Vec3 before = viewer.models().front()->box.center();
        EXPECT_NEAR((viewer.handles()[0] - before).dot(up), 0.14 * 2 * std::sqrt(3), 1e-9);
    }
}

TEST_F(PanelsOfFiles, VoronoiPanelSaysThatAModelHasNoEdges)
{
    const std::string points = path("points.xyz").string();
    std::ofstream(points) << "0 0 0\n1 0 0\n0 1 0.5\n";
    for (const std::vector<std::string>& settings :
         {std::vector<std::string>{"feature=edge"}, {"feature=edge", "number=0"}}) {
        Viewer viewer;
        viewer.resize(shown_size);
        ASSERT_TRUE(viewer.choose_panel("voronoi"));
        ASSERT_TRUE(apply_settings(settings, [&](Controls& controls) { viewer.offer(controls); }));
        viewer.open({points});
        const Status done = viewer.finish();
        ASSERT_FALSE(done);
        EXPECT_NE(done.error().message.find("no features of this kind"), std::string::npos);
        // Another kind is there.
        ASSERT_TRUE(apply_settings({"feature=vertex"},
                                   [&](Controls& controls) { viewer.offer(controls); }));
        EXPECT_TRUE(viewer.finish());
    }
}

TEST(Panels, VoronoiPanelBeginsAtTheFeatureThatIsAskedFor)
{
    Viewer viewer;
    open(viewer, "voronoi", {"number=5"}, {"icosphere:5"});
    const ViewModel& model = *viewer.models().front();
    EXPECT_LT((viewer.camera().target - model.mesh.positions()[5]).norm(), 1e-9);
    Viewer of_edge;
    open(of_edge, "voronoi", {"feature=edge", "number=20"}, {"icosphere:5"});
    const EdgeVertices& ends = model.topology.vertices(EdgeId{20});
    const Vec3 middle = 0.5 * (model.mesh.positions()[to_index(ends[0])] +
                               model.mesh.positions()[to_index(ends[1])]);
    EXPECT_LT((of_edge.camera().target - middle).norm(), 1e-9);
    Viewer of_face;
    open(of_face, "voronoi", {"feature=face", "number=7"}, {"icosphere:5"});
    const Triangle face = model.mesh.triangle(TriangleId{7});
    EXPECT_LT((of_face.camera().target - (face[0] + face[1] + face[2]) / 3.0).norm(), 1e-9);
}

TEST(Panels, LegendsNameOnlyWhatIsDrawn)
{
    const Shown missed({"cube"}, "rays", {"from x=5", "towards x=5", "towards y=3"});
    EXPECT_TRUE(missed.viewer.legend().entries.empty());
    EXPECT_TRUE(missed.viewer.legend().title.empty());
    const Shown nothing(
        {"cube"}, "culling",
        {"eye x=0", "eye y=4", "eye z=0", "target x=0", "target y=5", "target z=0"});
    EXPECT_FALSE(color_in_legend(nothing, "triangles in it"));
    EXPECT_FALSE(color_in_legend(nothing, "leaves in it"));
    EXPECT_TRUE(color_in_legend(nothing, "other triangles"));
    Shown all({"cube"}, "culling", {"field of view=150", "near=0.001", "far=5"});
    EXPECT_FALSE(color_in_legend(all, "other triangles"));
    EXPECT_TRUE(color_in_legend(all, "triangles in it"));
    const Shown alone({"cube"}, "closest", {"rings=0", "cursor x=0", "cursor y=0.5", "cursor z=5"});
    ASSERT_EQ(alone.triangles("patch"), 0U);
    EXPECT_FALSE(color_in_legend(alone, "triangles round it"));
}

TEST(Panels, CutPlaneTakesAwayTheSideOfTheEye)
{
    Shown shown({"icosphere:3"}, "octree", {"cut plane=on"});
    // z is up, and the eye stands at negative y.
    const std::array<std::tuple<std::string, Vec3>, 3> kept = {
        {{"x", -Vec3::UnitX()}, {"y", Vec3::UnitY()}, {"z", -Vec3::UnitZ()}}};
    for (const auto& [axis, normal] : kept) {
        for (const double side : {1.0, -1.0}) {
            shown.set({"cut axis=" + axis, side > 0 ? "other side=off" : "other side=on"});
            for (const SceneSurface& surface : shown.scene().surfaces) {
                if (surface.name != "mesh") continue;
                ASSERT_FALSE(surface.triangles.empty());
                for (const TriangleCorners& corners : surface.triangles) {
                    for (const std::uint32_t corner : corners)
                        EXPECT_GE(side * normal.dot(surface.positions[corner]), -1e-12) << axis;
                }
            }
        }
    }
}

TEST(Panels, RaysAreMeasuredInLengths)
{
    const Shown shown(
        {"cube"}, "rays",
        {"from x=0.1", "from y=0.2", "from z=3", "towards x=0.1", "towards y=0.2", "towards z=-2"});
    const std::string hit = shown.fact("first hit");
    EXPECT_TRUE(hit.ends_with(" at 2")) << hit;
    EXPECT_NEAR(shown.number("length in the root"), 2.0, 1e-3);
}

TEST(Panels, OctreePanelShowsTheCellsOfTheOctree)
{
    Shown shown({"icosphere:3"}, "octree", {"depth=4", "threshold=2"});
    const auto octree =
        build_octree(shown.viewer.models()[0]->mesh, {.max_depth = 4, .threshold = 2});
    ASSERT_TRUE(octree);
    const OctreeStatistics statistics = octree_statistics(*octree);
    EXPECT_EQ(shown.number("boundary"), static_cast<double>(statistics.boundary));
    EXPECT_EQ(shown.number("inner"), static_cast<double>(statistics.inner));
    EXPECT_EQ(shown.segments("cells"), distinct_edges(*octree, {CellClass::boundary}));
    shown.set({"inner=on", "outer=on"});
    EXPECT_EQ(shown.segments("cells"),
              distinct_edges(*octree, {CellClass::boundary, CellClass::inner, CellClass::outer}));
    shown.set({"boundary=off", "inner=off", "outer=off"});
    EXPECT_EQ(shown.segments("cells"), 0U);
}

TEST(Panels, UniformOctreeShowsEveryEdgeOfALatticeOnce)
{
    Shown shown({"cube"}, "octree",
                {"depth=2", "subdivision=uniform", "inner=on", "outer=on", "boundary=on",
                 "colour by=class"});
    shown.set({"mesh=off"});
    EXPECT_EQ(shown.number("leaves"), 64.0);
    const auto octree = build_octree(shown.viewer.models()[0]->mesh,
                                     {.max_depth = 2, .subdivision = Subdivision::uniform});
    ASSERT_TRUE(octree);
    const std::vector<CellClass> classes = {CellClass::boundary, CellClass::inner,
                                            CellClass::outer};
    EXPECT_EQ(distinct_edges(*octree, classes), 3U * 4U * 25U) << "of 4 x 4 x 4 cells";
    // Where classes meet edges are drawn once for each.
    std::size_t edges = 0;
    for (const CellClass type : classes) edges += distinct_edges(*octree, {type});
    EXPECT_EQ(shown.segments("cells"), edges);
    EXPECT_EQ(shown.triangles("mesh"), 0U);
}

TEST(Panels, CutPlaneFillsASliceAndCutsTheMesh)
{
    Shown shown({"icosphere:3"}, "octree",
                {"depth=3", "cut plane=on", "cut axis=z", "cut at=0", "inner=on", "outer=on"});
    double area = 0.0;
    for (const SceneSurface& surface : shown.scene().surfaces) {
        for (const TriangleCorners& corners : surface.triangles) {
            const auto& at = surface.positions;
            const Triangle triangle = {{at[corners[0]], at[corners[1]], at[corners[2]]}};
            if (surface.name == "cut cells") area += 0.5 * scaled_normal(triangle).norm();
            if (surface.name != "mesh") continue;
            for (const Vec3& corner : triangle.vertices) EXPECT_LE(corner.z(), 1e-12);
        }
    }
    const Vec3 root = shown.viewer.models()[0]->box.extent();
    EXPECT_NEAR(area, std::pow(root.maxCoeff(), 2), 1e-9);
}

TEST(Panels, CutPlaneFillsASliceAtBothEndsOfTheRoot)
{
    Shown shown({"cube"}, "octree",
                {"depth=2", "subdivision=uniform", "inner=on", "outer=on", "cut plane=on"});
    for (const char* const axis : {"x", "y", "z"}) {
        for (const char* const at : {"-1", "0", "1"}) {
            shown.set({std::string("cut axis=") + axis, std::string("cut at=") + at});
            EXPECT_EQ(shown.triangles("cut cells"), 2U * 16U) << axis << ' ' << at;
        }
    }
}

TEST(Panels, ClosestPanelFindsWhatBruteForceFinds)
{
    Shown shown({"torus:24x12"}, "closest");
    const ViewModel& model = *shown.viewer.models()[0];
    for (const Vec3& cursor : {Vec3(0.3, -0.7, 0.9), Vec3(1.1, 1.2, 0.2), Vec3(0, 0, 0.05)}) {
        shown.set({"cursor x=" + std::to_string(cursor.x()),
                   "cursor y=" + std::to_string(cursor.y()),
                   "cursor z=" + std::to_string(cursor.z()), "rings=2"});
        const ClosestFeature expected =
            closest_feature_by_brute_force(model.mesh, model.topology, cursor);
        EXPECT_NEAR(shown.number("distance"), std::sqrt(expected.squared_distance), 1e-5);
        EXPECT_GT(shown.triangles("patch"), 3U);
        EXPECT_EQ(shown.triangles("cursor"), 1280U);
    }
}

TEST(Panels, VoronoiPanelShowsThePickedFeature)
{
    Shown shown({"cube"}, "voronoi", {"feature=vertex", "number=3"});
    EXPECT_EQ(shown.fact("feature"), "vertex 3");
    EXPECT_EQ(shown.fact("region"), "drawn");
    EXPECT_GT(shown.triangles("region"), 3U);
    EXPECT_GT(shown.triangles("listed"), 0U);
}

TEST(Panels, VoronoiPanelStartsWithARegionNearTheCursor)
{
    for (const char* const model : {"cube", "torus:24x12", "spaceship:2000"}) {
        Shown shown({model}, "voronoi");
        for (const char* const kind : {"feature=vertex", "feature=edge", "feature=face"}) {
            shown.set({kind});
            EXPECT_EQ(shown.fact("region"), "drawn") << model << ' ' << kind;
        }
    }
}

TEST(Panels, VoronoiPanelShowsAFeatureOfTheModelThatIsChosen)
{
    // One that nobody has chosen, and one that somebody has: the cube has no such number.
    for (const std::vector<std::string>& chosen :
         {std::vector<std::string>{}, std::vector<std::string>{"number=600"}}) {
        for (const char* const kind : {"vertex", "edge", "face"}) {
            Shown shown({"icosphere:3", "cube"}, "voronoi", {std::string("feature=") + kind});
            shown.set(chosen);
            shown.set({"model=2"});
            const ViewModel& cube = *shown.viewer.models()[1];
            const std::size_t count = kind == std::string_view("vertex") ? cube.mesh.vertex_count()
                                      : kind == std::string_view("edge")
                                          ? cube.topology.edge_count()
                                          : cube.mesh.triangle_count();
            const std::string fact = shown.fact("feature");
            ASSERT_TRUE(fact.starts_with(kind)) << fact;
            EXPECT_LT(std::stoul(fact.substr(fact.find(' '))), count) << fact;
            EXPECT_TRUE(shown.fact("region").starts_with("drawn")) << shown.fact("region");
        }
    }
}

TEST(Panels, VoronoiPanelShowsRegionsBehindTheSurfaceThroughIt)
{
    Shown shown({"torus:24x12"}, "voronoi", {"feature=edge"});
    const auto opacity = [&] { return shown.viewer.layers().front().opacity; };
    EXPECT_EQ(opacity(), 1.0F);
    bool is_behind = false;
    for (int number = 0; number < 40 && !is_behind; ++number) {
        shown.set({"number=" + std::to_string(number)});
        is_behind = shown.fact("region").starts_with("drawn, behind the surface");
        EXPECT_EQ(opacity() < 0.5F, is_behind);
        EXPECT_GT(shown.triangles("region"), 0U);
    }
    EXPECT_TRUE(is_behind) << "edges of the hole are bent inward";
    shown.set({"feature=vertex"});
    bool is_empty = false;
    for (int number = 0; number < 40 && !is_empty; ++number) {
        shown.set({"number=" + std::to_string(number)});
        is_empty = shown.fact("region").starts_with("empty: ");
        EXPECT_EQ(shown.triangles("region") == 0U, is_empty);
    }
    EXPECT_TRUE(is_empty) << "the hole is a saddle";
}

TEST(Panels, VoronoiPanelFitsTheRegionIntoThePicture)
{
    Shown shown({"icosphere:4"}, "voronoi"); // small triangles: it begins near one
    const DrawnScene scene = shown.scene();
    const View view(shown.viewer.camera(), shown_size);
    std::size_t seen = 0;
    for (const SceneSurface& surface : scene.surfaces) {
        if (surface.name != "region") continue;
        for (const Vec3& position : surface.positions) {
            const ScreenPoint at = view.project(position);
            ASSERT_TRUE(at.x > 0.0 && at.x < shown_size.width && at.y > 0.0 &&
                        at.y < shown_size.height);
            ++seen;
        }
    }
    EXPECT_GT(seen, 50U);
    EXPECT_EQ(shown.fact("its end"), "none as far as it is drawn");
    // A length that a person has chosen is kept.
    shown.set({"length=1.5"});
    shown.viewer.open({"cube"});
    ASSERT_TRUE(shown.viewer.finish());
    EXPECT_GT((bounding_box(shown.viewer.layers()).extent().array() / 2.0).maxCoeff(), 1.5);
}

TEST(Panels, VoronoiPanelPlotsAllButTheLongestLists)
{
    Shown shown({"spaceship:2000"}, "voronoi");
    ASSERT_EQ(shown.viewer.plots().size(), 1U);
    const PanelPlot& plot = shown.viewer.plots()[0];
    float sum = 0.0F;
    for (const float value : plot.values) sum += value;
    // The longest lists, of a thousandth of the leaves, are left out.
    EXPECT_GE(sum, 0.999F * static_cast<float>(shown.number("leaves")));
    EXPECT_LE(plot.values.size(), static_cast<std::size_t>(shown.number("longest list")) + 1);
    EXPECT_EQ(plot.name, "leaves that list 0, 1, ... " + std::to_string(plot.values.size() - 1) +
                             " triangles");
}

TEST(Panels, RayPanelLightsEveryCellAlongTheRay)
{
    Shown shown({"icosphere:3"}, "rays", {"depth=4"});
    EXPECT_EQ(shown.number("triangles hit"), 2.0);
    EXPECT_EQ(static_cast<double>(shown.triangles("cell")),
              12.0 * shown.number("cells along the ray"));
    EXPECT_EQ(shown.triangles("hit"), 2U * 1280U);
    shown.set({"occupied only=on"});
    EXPECT_LT(shown.number("shown"), shown.number("cells along the ray"));
}

TEST(Panels, CullingPanelShowsOnlyVisibleTriangles)
{
    Shown shown({"icosphere:4"}, "culling");
    const double visible = shown.number("visible");
    EXPECT_GT(visible, 0.0);
    EXPECT_LT(visible, 5120.0);
    EXPECT_EQ(static_cast<double>(shown.triangles("visible")), visible);
    shown.set({"mode=exact"});
    EXPECT_LE(shown.number("visible"), visible);
    shown.set({"far=0.31"}); // a volume in front of the model
    EXPECT_EQ(shown.number("visible"), 0.0);
}

TEST(Panels, MinkowskiPanelPushesPlanesOutward)
{
    Shown shown({"cube"}, "minkowski",
                {"A=cube", "B=octahedron", "size of B=0.5", "copies of B=off"});
    EXPECT_EQ(shown.fact("facets"), "26");
    EXPECT_EQ(shown.fact("of A"), "6");
    EXPECT_EQ(shown.fact("of B"), "8");
    EXPECT_EQ(shown.fact("swept"), "12");
    EXPECT_NEAR(bounding_box(shown.viewer.layers()).upper.x(), 1.5, 1e-12);
    shown.set({"pushed=0.5"});
    EXPECT_NEAR(bounding_box(shown.viewer.layers()).upper.x(), 1.25, 1e-12);
    shown.set({"play=on"});
    EXPECT_TRUE(shown.viewer.is_moving());
    shown.viewer.update(0.1);
    ASSERT_TRUE(shown.viewer.finish());
    EXPECT_GT(bounding_box(shown.viewer.layers()).upper.x(), 1.25);
}

TEST_F(PanelsOfFiles, MinkowskiPanelSumsWhatTheTrianglesOfAModelBound)
{
    std::ofstream(path("stray.obj")) << "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\n"
                                        "v -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
                                        "v 10 0 0\n" // of no triangle
                                        "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\n"
                                        "f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    const Shown shown({path("stray.obj").string()}, "minkowski",
                      {"A=model", "B=octahedron", "size of B=0.5", "copies of B=off"});
    EXPECT_EQ(shown.fact("facets"), "26");
    EXPECT_EQ(shown.fact("corners"), "24 of 8 x 6 points");
    EXPECT_NEAR(bounding_box(shown.viewer.layers()).upper.x(), 1.5, 1e-12);
}

TEST(Panels, MinkowskiPanelStopsWhileItLooksAtTheModel)
{
    const auto models =
        load_view_models(std::vector<std::string>{"torus:48x24"}, Primitives::triangles, {});
    ASSERT_TRUE(models);
    const auto panel = make_minkowski_panel();
    panel->models_changed(*models, Vec3::UnitZ());
    const Status applied =
        apply_settings({"A=model"}, [&](Controls& controls) { panel->offer(controls); });
    ASSERT_TRUE(applied);
    Progress stopped;
    stopped.cancel();
    const auto picture = panel->task(*models)({.progress = &stopped});
    ASSERT_FALSE(picture);
    EXPECT_EQ(code_of(picture), ErrorCode::cancelled) << describe(picture.error());
}

TEST(Panels, FramesWhatAPanelShows)
{
    Shown shown({"icosphere:2"}, "model");
    const double distance = shown.viewer.camera().distance;
    // It is framed when it is chosen. Bodies reach as far as the model, to 1, and B is 0.55 as large
    // at first: the box of their sum holds a model of 1.55.
    shown.set({"panel=minkowski", "size of B=2"});
    EXPECT_GE(shown.viewer.camera().distance, 1.55 * distance);
    shown.set({"panel=octree"});
    EXPECT_EQ(shown.viewer.camera().distance, distance);
}

TEST(Panels, TouchPanelFeelsTheSurface)
{
    Shown shown({"icosphere:3"}, "touch", {"hand x=0", "hand y=0", "hand z=0.7"});
    EXPECT_NE(shown.fact("contact"), "free");
    EXPECT_NEAR(shown.number("force"), force_at_rest(*shown.viewer.models()[0], 0.3), 1e-3);
    // The proxy stays on the unit sphere although the hand pulls below it.
    EXPECT_GT(shown.triangles("proxy"), 0U);
    for (const SceneSurface& surface : shown.scene().surfaces) {
        if (surface.name != "proxy") continue;
        Box box;
        for (const Vec3& position : surface.positions) box.extend(position);
        EXPECT_NEAR(box.center().norm(), 1.0, 1e-8) << "a billionth of the extent from it";
    }
    shown.set({"hand z=1.5"});
    EXPECT_EQ(shown.fact("contact"), "free");
    EXPECT_EQ(shown.number("force"), 0.0);
}

TEST(Panels, TouchPanelStopsWhereItIsAskedTo)
{
    const auto models =
        load_view_models(std::vector<std::string>{"icosphere:3"}, Primitives::triangles, {});
    ASSERT_TRUE(models);
    const auto panel = make_touch_panel(Pictures::still);
    panel->models_changed(*models, Vec3::UnitZ());
    Progress stopped;
    stopped.cancel();
    const auto picture = panel->task(*models)({.progress = &stopped});
    ASSERT_FALSE(picture);
    EXPECT_EQ(code_of(picture), ErrorCode::cancelled);
    // Where there is no memory to find its inside, it is touched all the same.
    EXPECT_TRUE(panel->task(*models)({.budget = {1}}));
}

TEST(Panels, WindowsDoNotWaitForWhatTouchPanelsBuild)
{
    const auto models =
        load_view_models(std::vector<std::string>{"icosphere:6"}, Primitives::triangles, {});
    ASSERT_TRUE(models);
    // A frame that comes back in time can stop the work. It may come late on a busy machine, but not
    // again and again.
    bool was_stopped = false;
    for (int i = 0; i < 10 && !was_stopped; ++i) {
        const auto panel = make_touch_panel(Pictures::live);
        panel->models_changed(*models, Vec3::UnitZ());
        Progress progress;
        std::atomic<bool> is_done = false;
        std::thread worker([&] {
            was_stopped = !panel->task(*models)({.progress = &progress});
            is_done = true;
        });
        while (*progress.stage() == '\0' && !is_done) std::this_thread::yield();
        PanelPicture frame;
        panel->add_live(frame);
        progress.cancel();
        worker.join();
    }
    EXPECT_TRUE(was_stopped);
}

TEST(Panels, TouchRunsLiveWithLivePictures)
{
    Viewer viewer({.pictures = Pictures::live});
    ASSERT_TRUE(viewer.choose_panel("touch"));
    viewer.open({"icosphere:2"});
    ASSERT_TRUE(viewer.finish());
    EXPECT_TRUE(viewer.is_moving());
    const auto has_rate = [&] {
        return std::ranges::find(viewer.facts(), std::string("servo rate"), &PanelFact::name) !=
               viewer.facts().end();
    };
    while (!has_rate()) viewer.update(0.01);
    ASSERT_TRUE(viewer.choose_panel("model"));
    EXPECT_FALSE(viewer.is_moving()) << "another panel ends the loop";
}

} // namespace
} // namespace proxima::panels_test
