#include "cli/octree_picture.h"

#include "base/progress.h"
#include "cli/canvas.h"
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

/// Triangles that the options' volume sees, and those that it does not.
SurfaceColor surface_color(const TriangleMesh& mesh, const PictureOptions& options)
{
    if (options.volume == nullptr) return {};
    return [&](TriangleId id) {
        const Triangle triangle = mesh.triangle(id);
        const bool seen = options.mode == CullMode::exact
                              ? meets_volume(*options.volume, triangle)
                              : passes_planes(*options.volume, triangle);
        return seen ? srgb(0xF2B134) : srgb(0x8A93A0);
    };
}

/// Colour of cells at `part` of the way from the coarsest leaves (0) to the finest (1).
Color depth_color(double part)
{
    const std::array<Color, 6> stops = {srgb(0x4527A0), srgb(0x1565C0), srgb(0x00897B),
                                        srgb(0x689F38), srgb(0xEF6C00), srgb(0xC2185B)};
    const double position = std::clamp(part, 0.0, 1.0) * (stops.size() - 1);
    const auto stop = std::min(static_cast<std::size_t>(position), stops.size() - 2);
    const auto rest = static_cast<float>(position - static_cast<double>(stop));
    return (1.0F - rest) * stops[stop] + rest * stops[stop + 1];
}

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

Vec3 box_corner(const Box& box, int bits)
{
    return {(bits & 1) != 0 ? box.upper.x() : box.lower.x(),
            (bits & 2) != 0 ? box.upper.y() : box.lower.y(),
            (bits & 4) != 0 ? box.upper.z() : box.lower.z()};
}

/// Which of the two faces across `axis` the eye sees: -1 lower, 1 upper, 0 neither.
int seen_side(const Box& box, const Vec3& eye, int axis)
{
    return eye[axis] < box.lower[axis] ? -1 : eye[axis] > box.upper[axis] ? 1 : 0;
}

void hide_lines_behind(Canvas& canvas, const Camera& camera, const Box& box)
{
    for (int axis = 0; axis < 3; ++axis) {
        const int side = seen_side(box, camera.eye(), axis);
        if (side == 0) continue;
        const int fixed = side > 0 ? 1 << axis : 0;
        const int b = 1 << ((axis + 1) % 3);
        const int c = 1 << ((axis + 2) % 3);
        const auto at = [&](int bits) { return camera.project(box_corner(box, fixed | bits)); };
        canvas.hide_lines_behind({at(0), at(b), at(b | c)});
        canvas.hide_lines_behind({at(0), at(b | c), at(c)});
    }
}

/// Draws the edges of the faces that the eye sees.
void draw_edges(Canvas& canvas, const Camera& camera, const Box& box, const Color& color,
                const LineStyle& style)
{
    for (int axis = 0; axis < 3; ++axis) {
        const int b = (axis + 1) % 3;
        const int c = (axis + 2) % 3;
        for (int sides = 0; sides < 4; ++sides) {
            const int side_b = (sides & 1) != 0 ? 1 : -1;
            const int side_c = (sides & 2) != 0 ? 1 : -1;
            if (seen_side(box, camera.eye(), b) != side_b &&
                seen_side(box, camera.eye(), c) != side_c) {
                continue;
            }
            const int bits = (side_b > 0 ? 1 << b : 0) | (side_c > 0 ? 1 << c : 0);
            canvas.draw_line(camera.project(box_corner(box, bits)),
                             camera.project(box_corner(box, bits | 1 << axis)), color, style);
        }
    }
}

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

void draw_leaves(Canvas& canvas, const Camera& camera, std::span<const Leaf> leaves,
                 const PictureOptions& options)
{
    StageSteps steps(options.execution.progress, "drawing the cells", 2 * leaves.size(),
                     cells_per_step);
    if (leaves.empty()) return;
    const int coarsest = options.depths ? (*options.depths)[0] : depth(leaves.back().key);
    const int finest =
        std::max(options.depths ? (*options.depths)[1] : depth(leaves.front().key), coarsest + 1);
    // Cells are glass that hides lines of cells as coarse or coarser behind it: a large cell that
    // touches the surface with a corner lets the small ones behind it be seen.
    std::size_t paned = 0;
    for (const Leaf& leaf : leaves) {
        while (paned < leaves.size() && depth(leaves[paned].key) == depth(leaf.key)) {
            hide_lines_behind(canvas, camera, leaves[paned].box);
            ++paned;
            if (!steps.done(1)) return;
        }
        const ScreenPoint lower = camera.project(leaf.box.lower);
        const ScreenPoint upper = camera.project(leaf.box.upper);
        const double pixels = std::hypot(upper.x - lower.x, upper.y - lower.y);
        const double part = static_cast<double>(depth(leaf.key) - coarsest) / (finest - coarsest);
        const LineStyle style{.width = std::clamp(0.05 * pixels, 0.9, 2.0),
                              .opacity = static_cast<float>(std::clamp(0.04 * pixels, 0.18, 0.95)),
                              .lift = 2e-3};
        draw_edges(canvas, camera, leaf.box, depth_color(part), style);
        if (!steps.done(1)) return;
    }
}

} // namespace

Result<Image> draw_octree(const Octree& octree, const TriangleMesh& mesh,
                          const PictureOptions& options)
{
    Canvas canvas(options.width, options.height, options.execution.progress);
    canvas.fill_background(srgb(0xFBFCFE), srgb(0xE3E8EF));
    const std::vector<Leaf> leaves = occupied_leaves(octree, options);
    std::vector<Vec3> corners;
    for (const Leaf& leaf : leaves) {
        for (int bits = 0; bits < 8; ++bits) corners.push_back(box_corner(leaf.box, bits));
    }
    Box shown = bounding_box(mesh);
    if (shown.empty()) {
        for (const Vec3& corner : corners) shown.extend(corner);
    }
    // With a volume the whole mesh is shown, its leaves are not all there.
    for (int bits = 0; bits < 8 && options.volume != nullptr && !shown.empty(); ++bits)
        corners.push_back(box_corner(shown, bits));
    if (options.frame) {
        corners.clear();
        for (int bits = 0; bits < 8; ++bits) corners.push_back(box_corner(*options.frame, bits));
    }
    Camera camera(shown, options.up);
    camera.fit(corners, options.width, options.height);
    draw_mesh(canvas, camera, mesh, surface_color(mesh, options), options.execution.progress);
    begin_stage(options.execution.progress, "shading", 1);
    canvas.darken_creases(14.0, 0.55F);
    draw_leaves(canvas, camera, leaves, options);
    Image image = canvas.image();
    if (is_cancelled(options.execution.progress)) {
        return cancelled("drawing");
    }
    return image;
}

} // namespace proxima
