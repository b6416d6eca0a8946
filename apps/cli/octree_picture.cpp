#include "cli/octree_picture.h"

#include "cli/canvas.h"
#include "cli/lamps.h"
#include "proxima/octree/traverse.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>

namespace proxima {

namespace {

// The eye looks from the right, a little above, at a scene scaled to radius 1.
constexpr double azimuth = 0.42;   // radians from the front
constexpr double elevation = 0.30; // radians above the horizon
constexpr double eye_distance = 4.0;
constexpr double margin = 0.05; // of the picture, kept free on each side

/// Perspective view of a box.
class Camera {
public:
    Camera(const Box& box, UpAxis up)
        : center_(box.center()), scale_(2.0 / std::max(box.extent().norm(), 1e-300))
    {
        const bool y_up = up == UpAxis::y;
        up_ = y_up ? Vec3(0, 1, 0) : Vec3(0, 0, 1);
        const Vec3 front = y_up ? Vec3(0, 0, 1) : Vec3(0, -1, 0);
        const Vec3 side = up_.cross(front);
        back_ = std::cos(elevation) * (std::cos(azimuth) * front + std::sin(azimuth) * side) +
                std::sin(elevation) * up_;
        right_ = up_.cross(back_).normalized();
        up_ = back_.cross(right_);
        eye_ = center_ + eye_distance / scale_ * back_;
    }

    /// Moves and zooms so that all points fill the picture but for its margin.
    void fit(std::span<const Vec3> points, const PictureOptions& options)
    {
        Eigen::AlignedBox2d seen;
        for (const Vec3& point : points) {
            const ScreenPoint at = project(point);
            seen.extend(Vec2(at.x, at.y));
        }
        const Vec2 size(options.width, options.height);
        const Vec2 room = (1.0 - 2.0 * margin) * size;
        zoom_ = (room.array() / seen.sizes().array().max(1e-12)).minCoeff();
        origin_ = 0.5 * size - zoom_ * seen.center();
    }

    [[nodiscard]] const Vec3& eye() const noexcept { return eye_; }

    [[nodiscard]] Lamps lamps() const { return {right_, up_, back_}; }

    [[nodiscard]] ScreenPoint project(const Vec3& point) const noexcept
    {
        const Vec3 offset = scale_ * (point - center_);
        const double nearness = 1.0 / (eye_distance - back_.dot(offset));
        return {origin_.x() + zoom_ * right_.dot(offset) * nearness,
                origin_.y() - zoom_ * up_.dot(offset) * nearness, nearness};
    }

private:
    Vec3 center_;
    double scale_;
    Vec3 right_;
    Vec3 up_;
    Vec3 back_; // from the scene to the eye
    Vec3 eye_;
    double zoom_ = 1.0; // pixels
    Vec2 origin_ = Vec2::Zero();
};

/// Few enough triangles or leaves to be drawn in some milliseconds.
constexpr std::uint64_t block = 256;

/// Area-weighted vertex normals, not of unit length.
std::vector<Vec3> vertex_normals(const TriangleMesh& mesh, StageSteps& steps)
{
    std::vector<Vec3> normals(mesh.vertex_count(), Vec3::Zero());
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Vec3 normal = scaled_normal(mesh.triangle(TriangleId{i}));
        for (const std::uint32_t corner : mesh.triangles()[i]) normals[corner] += normal;
        if (!steps.done(1)) break;
    }
    return normals;
}

void draw_mesh(Canvas& canvas, const Camera& camera, const TriangleMesh& mesh, Progress* progress)
{
    constexpr double smooth_below = 0.7; // cosine of the angle between a face and its smooth normal
    const Color surface = srgb(0xE9E1D2);
    const Lamps lamps = camera.lamps();
    StageSteps steps(progress, "drawing the mesh", 2 * mesh.triangle_count(), block);
    const std::vector<Vec3> normals = vertex_normals(mesh, steps);
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
        const Triangle triangle = mesh.triangle(TriangleId{i});
        const Vec3 face = scaled_normal(triangle).normalized();
        // Seen from behind, a surface is lit as if it faced the eye: open meshes show their inside.
        const double side = face.dot(camera.eye() - triangle[0]) < 0.0 ? -1.0 : 1.0;
        std::array<ScreenVertex, 3> vertices;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const Vec3 smooth = normals[mesh.triangles()[i][corner]].normalized();
            const Vec3 normal = side * (smooth.dot(face) > smooth_below ? smooth : face);
            vertices[corner] = {camera.project(triangle.vertices[corner]),
                                lamps.shade(normal, surface)};
        }
        canvas.draw_triangle(vertices);
        if (!steps.done(1)) return;
    }
}

/// Colour of cells at `part` of the way from the coarsest leaves (0) to the finest (1).
Color depth_color(double part)
{
    const std::array<Color, 6> stops = {srgb(0x4527A0), srgb(0x1565C0), srgb(0x00897B),
                                        srgb(0x689F38), srgb(0xEF6C00), srgb(0xC2185B)};
    const double place = std::clamp(part, 0.0, 1.0) * (stops.size() - 1);
    const auto stop = std::min(static_cast<std::size_t>(place), stops.size() - 2);
    const auto rest = static_cast<float>(place - static_cast<double>(stop));
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

/// The leaves that hold triangles, fine ones first.
std::vector<Leaf> occupied_leaves(const Octree& octree, const Progress* progress)
{
    std::vector<Leaf> leaves;
    traverse(octree, LeafCollector{octree, leaves, progress});
    const auto finer = [](const Leaf& a, const Leaf& b) { return depth(a.key) > depth(b.key); };
    std::ranges::stable_sort(leaves, finer);
    return leaves;
}

void draw_leaves(Canvas& canvas, const Camera& camera, std::span<const Leaf> leaves,
                 Progress* progress)
{
    StageSteps steps(progress, "drawing the cells", 2 * leaves.size(), block);
    if (leaves.empty()) return;
    const int coarsest = depth(leaves.back().key);
    const int finest = std::max(depth(leaves.front().key), coarsest + 1);
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
    Canvas canvas(options.width, options.height, options.progress);
    canvas.fill_background(srgb(0xFBFCFE), srgb(0xE3E8EF));
    const std::vector<Leaf> leaves = occupied_leaves(octree, options.progress);
    std::vector<Vec3> corners;
    for (const Leaf& leaf : leaves) {
        for (int bits = 0; bits < 8; ++bits) corners.push_back(box_corner(leaf.box, bits));
    }
    Box shown = bounding_box(mesh);
    if (shown.empty()) {
        for (const Vec3& corner : corners) shown.extend(corner);
    }
    Camera camera(shown, options.up);
    camera.fit(corners, options);
    draw_mesh(canvas, camera, mesh, options.progress);
    if (options.progress != nullptr) options.progress->begin_stage("shading", 1);
    canvas.darken_creases(14.0, 0.55F);
    draw_leaves(canvas, camera, leaves, options.progress);
    Image image = canvas.image();
    if (is_cancelled(options.progress)) {
        return fail(ErrorCode::cancelled, "drawing was stopped on request");
    }
    return image;
}

} // namespace proxima
