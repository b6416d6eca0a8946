// What is wrong with a model, drawn and counted.
#include "proxima/mesh_io.h"
#include "viewer/shown_viewer.h"

#include <filesystem>

namespace proxima::model_panel_test {
namespace {

/// Two faces that run along their common edge the same way, and three faces at another edge.
TriangleMesh flawed_mesh()
{
    return *make_triangle_mesh({{0, 0, 0},
                                {1, 0, 0},
                                {0, 1, 0},
                                {0, -1, 0},
                                {3, 0, 0},
                                {4, 0, 0},
                                {3, 1, 0},
                                {3, -1, 0},
                                {3, 0, 1}},
                               {{0, 1, 2}, {0, 1, 3}, {4, 5, 6}, {5, 4, 7}, {4, 5, 8}});
}

TEST(ModelPanel, HighlightsFaultyEdges)
{
    const std::string path = "model_panel_test.obj";
    ASSERT_TRUE(write_mesh(flawed_mesh(), path));
    Shown shown({path}, "model");
    std::filesystem::remove(path);
    EXPECT_EQ(shown.fact("model"), path);
    EXPECT_EQ(shown.fact("boundary edges"), "10 (red)");
    EXPECT_EQ(shown.fact("non manifold edges"), "1 (violet)");
    EXPECT_EQ(shown.fact("inconsistent edges"), "1 (orange)");
    EXPECT_EQ(shown.segments("boundary_edges"), 10U);
    EXPECT_EQ(shown.segments("non_manifold_edges"), 1U);
    EXPECT_EQ(shown.segments("inconsistent_edges"), 1U);
    shown.set({"flaws=off"});
    EXPECT_EQ(shown.segments("boundary_edges"), 0U);
    EXPECT_EQ(shown.fact("boundary edges"), "10 (red)");
}

TEST(ModelPanel, ReportsNoFaultOfASoundModel)
{
    const Shown shown({"icosphere:2"}, "model");
    EXPECT_EQ(shown.viewer.facts().size(), 4U);
    EXPECT_TRUE(shown.scene().lines.empty());
}

TEST(ModelPanel, FactsOfAPanelDisappearWithIt)
{
    Shown shown({"icosphere:2"}, "model");
    EXPECT_NE(shown.fact("vertices"), "");
    ASSERT_TRUE(shown.viewer.choose_panel("octree"));
    shown.viewer.update(0.0);
    EXPECT_EQ(shown.fact("vertices"), "") << "while the octree is built";
    ASSERT_TRUE(shown.viewer.finish());
    EXPECT_NE(shown.fact("cells"), "");
}

} // namespace
} // namespace proxima::model_panel_test
