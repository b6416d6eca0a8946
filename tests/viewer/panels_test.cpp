// What panels show without a window, held against slow oracles.
#include "proxima/octree.h"
#include "query/closest/brute_force.h"
#include "viewer/shown_viewer.h"

namespace proxima {
namespace {

TEST(Panels, PanelsOfSmallThingsBeginNearThem)
{
    Shown shown({"icosphere:5"}, "model");
    const double distance = shown.viewer.camera().distance;
    for (const char* const panel : {"panel=closest", "panel=voronoi", "panel=touch"}) {
        shown.set({panel});
        EXPECT_LT(shown.viewer.camera().distance, 0.8 * distance) << panel;
        // What it is about is in the picture.
        const View view(shown.viewer.camera(), shown_size);
        const ScreenPoint at = view.project(shown.viewer.handles().front());
        EXPECT_GT(at.x, 0.2 * shown_size.width) << panel;
        EXPECT_LT(at.x, 0.8 * shown_size.width) << panel;
        EXPECT_GT(at.y, 0.2 * shown_size.height) << panel;
        EXPECT_LT(at.y, 0.8 * shown_size.height) << panel;
    }
    EXPECT_GT(shown.number("force"), 0.1) << "it is touched at once";
    shown.viewer.frame_all();
    EXPECT_EQ(shown.viewer.camera().distance, distance);
}

TEST(Panels, CullingPanelHasItsVolumeInThePicture)
{
    const Shown shown({"icosphere:4"}, "culling");
    const View view(shown.viewer.camera(), shown_size);
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

TEST(Panels, OctreePanelShowsTheOctreesCells)
{
    Shown shown({"icosphere:3"}, "octree", {"depth=4", "threshold=2"});
    const auto octree =
        build_octree(shown.viewer.models()[0]->mesh, {.max_depth = 4, .threshold = 2});
    ASSERT_TRUE(octree);
    const OctreeStatistics statistics = octree_statistics(*octree);
    EXPECT_EQ(shown.number("boundary"), static_cast<double>(statistics.boundary));
    EXPECT_EQ(shown.number("inner"), static_cast<double>(statistics.inner));
    // Leaves of one size share edges: between 3 and 12 edges each.
    EXPECT_GT(shown.segments("cells"), 3 * statistics.boundary);
    EXPECT_LT(shown.segments("cells"), 12 * statistics.boundary);
    const std::size_t boundary_alone = shown.segments("cells");
    shown.set({"inner=on", "outer=on"});
    EXPECT_GT(shown.segments("cells"), boundary_alone);
    shown.set({"boundary=off", "inner=off", "outer=off"});
    EXPECT_EQ(shown.segments("cells"), 0U);
}

TEST(Panels, UniformOctreeHasALatticeOfEdgesEachOnce)
{
    Shown shown({"cube"}, "octree",
                {"depth=2", "subdivision=uniform", "inner=on", "outer=on", "boundary=on",
                 "colour by=class"});
    shown.set({"mesh=off"});
    EXPECT_EQ(shown.number("leaves"), 64.0);
    // 4 x 4 x 4 cells have 3 * 4 * 25 edges; where classes meet they are drawn once for each.
    EXPECT_GE(shown.segments("cells"), 300U);
    EXPECT_LT(shown.segments("cells"), 600U);
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

TEST(Panels, VoronoiPanelBeginsWithARegionNearTheCursor)
{
    for (const char* const model : {"cube", "torus:24x12", "spaceship:2000"}) {
        Shown shown({model}, "voronoi");
        for (const char* const kind : {"feature=vertex", "feature=edge", "feature=face"}) {
            shown.set({kind});
            EXPECT_EQ(shown.fact("region"), "drawn") << model << ' ' << kind;
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

TEST(Panels, VoronoiPanelShowsAsMuchOfTheRegionAsThePictureHolds)
{
    Shown shown({"icosphere:4"}, "voronoi"); // small triangles: it begins near one
    const Scene scene = shown.scene();
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

TEST(Panels, VoronoiPanelPlotsMostListsOfLeaves)
{
    Shown shown({"spaceship:2000"}, "voronoi");
    ASSERT_EQ(shown.viewer.plots().size(), 1U);
    const PanelPlot& plot = shown.viewer.plots()[0];
    float sum = 0.0F;
    for (const float value : plot.values) sum += value;
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

TEST(Panels, CullingPanelShowsVisibleTrianglesAlone)
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

TEST(Panels, FramesWhatAPanelShows)
{
    Shown shown({"icosphere:2"}, "model");
    const double distance = shown.viewer.camera().distance;
    shown.set({"panel=minkowski", "size of B=2"});
    EXPECT_GT(shown.viewer.camera().distance, 1.2 * distance);
    shown.set({"panel=octree"});
    EXPECT_EQ(shown.viewer.camera().distance, distance);
}

TEST(Panels, TouchPanelFeelsTheSurface)
{
    Shown shown({"icosphere:3"}, "touch", {"hand x=0", "hand y=0", "hand z=0.7"});
    EXPECT_NE(shown.fact("contact"), "free");
    EXPECT_GT(shown.number("force"), 0.5);
    // The proxy stays on the unit sphere although the hand pulls below it.
    for (const SceneSurface& surface : shown.scene().surfaces) {
        if (surface.name != "proxy") continue;
        Box box;
        for (const Vec3& place : surface.positions) box.extend(place);
        EXPECT_NEAR(box.center().norm(), 1.0, 0.02);
    }
    shown.set({"hand z=1.5"});
    EXPECT_EQ(shown.fact("contact"), "free");
    EXPECT_EQ(shown.number("force"), 0.0);
}

TEST(Panels, TouchIsLiveWhereThePicturesAre)
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
} // namespace proxima
