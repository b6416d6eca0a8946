#include "cli/octree_picture.h"

#include "base/progress.h"
#include "base/text.h"
#include "cli/canvas.h"
#include "cli/legend.h"
#include "cli/picture_scene.h"
#include "geometry/view_contact.h"
#include "proxima/cull.h"
#include "proxima/octree.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>

namespace proxima {

namespace {

/// Few enough leaves to be drawn in some milliseconds.
constexpr std::uint64_t cells_per_step = 256;

constexpr unsigned seen_color = 0xF2B134;
constexpr unsigned unseen_color = 0x8A93A0;

/// Triangles that the options' volume sees, and those that it does not.
SurfaceColor surface_color(const TriangleMesh& mesh, const PictureOptions& options)
{
    if (options.volume == nullptr) return {};
    return [&](TriangleId id) {
        const Triangle triangle = mesh.triangle(id);
        const bool seen = options.mode == CullMode::exact
                              ? meets_volume(*options.volume, triangle)
                              : passes_planes(*options.volume, triangle);
        return srgb(seen ? seen_color : unseen_color);
    };
}

/// Colours of leaves by depth, from the coarsest to the finest.
class DepthColors {
public:
    DepthColors(int coarsest, int finest)
        : coarsest_(coarsest), steps_(std::max(finest - coarsest, 1))
    {}

    [[nodiscard]] Color operator()(int depth) const
    {
        const std::array<Color, 6> stops = {srgb(0x4527A0), srgb(0x1565C0), srgb(0x00897B),
                                            srgb(0x689F38), srgb(0xEF6C00), srgb(0xC2185B)};
        const double part = static_cast<double>(depth - coarsest_) / steps_;
        const double position = std::clamp(part, 0.0, 1.0) * (stops.size() - 1);
        const auto stop = std::min(static_cast<std::size_t>(position), stops.size() - 2);
        const auto rest = static_cast<float>(position - static_cast<double>(stop));
        return (1.0F - rest) * stops[stop] + rest * stops[stop + 1];
    }

private:
    int coarsest_;
    int steps_;
};

struct Leaf {
    CellKey key;
    Box box;
};

/// Collects the leaves that hold triangles.
struct LeafCollector {
    const Octree& octree;
    std::vector<Leaf>& leaves;
    const Progress* progress;

    [[nodiscard]] bool should_enter(const Cell&) const { return true; }
    Flow visit_leaf(const Cell& cell, std::span<const TriangleId> triangles)
    {
        if (!triangles.empty()) leaves.push_back({cell.key, octree.box(cell)});
        return is_cancelled(progress) ? Flow::stop : Flow::proceed;
    }
};

/// The leaves that hold triangles and are seen, fine ones first.
std::vector<Leaf> occupied_leaves(const Octree& octree, const PictureOptions& options)
{
    std::vector<Leaf> leaves;
    LeafCollector collector{octree, leaves, options.execution.progress};
    if (options.volume == nullptr) {
        traverse(octree, collector);
    } else {
        visible_cells(octree, *options.volume, options.mode, [&](const VisibleCell& at) {
            return collector.visit_leaf(at.cell, octree.triangles(at.cell));
        });
    }
    const auto finer = [](const Leaf& a, const Leaf& b) { return depth(a.key) > depth(b.key); };
    std::ranges::stable_sort(leaves, finer);
    return leaves;
}

DepthColors depth_colors(std::span<const Leaf> leaves, const PictureOptions& options)
{
    if (options.depths) return {(*options.depths)[0], (*options.depths)[1]};
    if (leaves.empty()) return {0, 1};
    return {depth(leaves.back().key), depth(leaves.front().key)};
}

Legend legend_of(std::span<const Leaf> leaves, const DepthColors& colors,
                 const PictureOptions& options)
{
    Legend legend;
    int last = -1;
    for (std::size_t i = leaves.size(); i-- > 0;) {
        const int level = depth(leaves[i].key);
        if (level == last) continue;
        legend.entries.push_back({hex_of(colors(level)), concat("leaves of depth ", level)});
        last = level;
    }
    if (options.volume != nullptr) {
        legend.entries.push_back({seen_color, "triangles seen"});
        legend.entries.push_back({unseen_color, "not seen"});
    }
    return legend;
}

void draw_leaves(Canvas& canvas, const View& view, std::span<const Leaf> leaves,
                 const DepthColors& colors, Progress* progress)
{
    StageSteps steps(progress, "drawing the cells", 2 * leaves.size(), cells_per_step);
    // Cells are glass that hides lines of cells as coarse or coarser behind it: a large cell that
    // touches the surface with a corner lets the small ones behind it be seen.
    std::size_t paned = 0;
    for (const Leaf& leaf : leaves) {
        while (paned < leaves.size() && depth(leaves[paned].key) == depth(leaf.key)) {
            hide_lines_behind(canvas, view, corners(leaves[paned].box));
            ++paned;
            if (!steps.done(1)) return;
        }
        // As long as its diagonal would be across the view.
        const double distance = std::max(view.depth(leaf.box.center()), view.near());
        const double pixels = view.pixels_at(distance) * leaf.box.extent().norm();
        const LineStyle style{.width = std::clamp(0.05 * pixels, 0.9, 2.0),
                              .opacity = static_cast<float>(std::clamp(0.04 * pixels, 0.18, 0.95)),
                              .lift = 2e-3};
        draw_box_edges(canvas, view, corners(leaf.box), colors(depth(leaf.key)), style);
        if (!steps.done(1)) return;
    }
}

} // namespace

Result<Image> draw_octree(const Octree& octree, const TriangleMesh& mesh,
                          const PictureOptions& options)
{
    const ViewSize size = options.view.size;
    auto drawn = make_canvas(size.width, size.height, {srgb(0xFBFCFE), srgb(0xE3E8EF)},
                             options.execution.progress, options.execution.budget);
    if (!drawn) return tl::unexpected(drawn.error());
    Canvas& canvas = *drawn;
    const std::vector<Leaf> leaves = occupied_leaves(octree, options);
    std::vector<Vec3> shown;
    const auto show = [&](const Box& box) {
        for (const Vec3& corner : corners(box)) shown.push_back(corner);
    };
    if (options.frame) {
        show(*options.frame);
    } else {
        for (const Leaf& leaf : leaves) show(leaf.box);
        // With a volume the whole mesh is shown, its leaves are not all there.
        if (options.volume != nullptr) shown = points_to_frame(mesh);
    }
    const auto camera = placed_camera(options.view, shown);
    if (!camera) return tl::unexpected(camera.error());
    const View view(*camera, size);
    draw_mesh(canvas, view, mesh, surface_color(mesh, options), options.execution.progress);
    begin_stage(options.execution.progress, "shading", 1);
    canvas.darken_creases(14.0, 0.55F);
    const DepthColors colors = depth_colors(leaves, options);
    draw_leaves(canvas, view, leaves, colors, options.execution.progress);
    Image image = canvas.image();
    if (is_cancelled(options.execution.progress)) return cancelled("drawing");
    if (options.with_legend) draw_legend(image, legend_of(leaves, colors, options));
    return image;
}

} // namespace proxima
