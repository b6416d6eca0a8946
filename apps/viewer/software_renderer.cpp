#include "base/progress.h"
#include "cli/lamps.h"
#include "viewer/renderer.h"

#include <algorithm>
#include <variant>

namespace proxima {
namespace {

/// The triangle's own normal, or one of its corners', turned to the eye: what is seen from behind
/// is lit as if it faced the eye, so that open surfaces show their inside.
class Shading {
public:
    Shading(const SceneSurface& surface, const View& view, const Lamps& lamps)
        : surface_(surface), view_(view), lamps_(lamps)
    {}

    [[nodiscard]] Color corner(const TriangleCorners& triangle, std::size_t k) const
    {
        if (surface_.lighting == Lighting::flat) return surface_.color;
        const Vec3 face = face_normal(triangle);
        const bool faces_away = face.dot(view_.eye() - surface_.positions[triangle[0]]) < 0.0;
        const Vec3 normal = surface_.normals.empty() ? face : surface_.normals[triangle[k]];
        return lamps_.shade(faces_away ? Vec3(-normal) : normal, surface_.color);
    }

private:
    [[nodiscard]] Vec3 face_normal(const TriangleCorners& triangle) const
    {
        const auto& at = surface_.positions;
        return scaled_normal({{at[triangle[0]], at[triangle[1]], at[triangle[2]]}})
            .stableNormalized();
    }

    const SceneSurface& surface_;
    const View& view_;
    const Lamps& lamps_;
};

struct Pane {
    std::array<ScreenPoint, 3> corners;
    Color color;
    float opacity = 1.0F;
};

struct Stroke {
    ScreenPoint from;
    ScreenPoint to;
    Color color;
    LineStyle style;
};

/// What is blended over the opaque surfaces, from far to near.
struct Blended {
    double nearness = 0.0; ///< of its middle
    std::variant<Pane, Stroke> what;
};

class SoftwareRenderer final : public Renderer {
public:
    explicit SoftwareRenderer(const Progress* progress) : progress_(progress) {}

    Result<Image> render(const DrawnScene& scene, const OrbitCamera& camera, ViewSize size) override
    {
        auto drawn = make_canvas(size.width, size.height,
                                 {scene.background_top, scene.background_bottom}, progress_);
        if (!drawn) return tl::unexpected(drawn.error());
        Canvas& canvas = *drawn;
        const View view(camera, size);
        const Lamps lamps(view.right(), view.up(), view.back());
        std::vector<Blended> blended;
        for (const SceneSurface& surface : scene.surfaces)
            draw_surface(canvas, surface, view, lamps, blended);
        if (scene.creases > 0.0F) canvas.darken_creases(14.0, scene.creases);
        for (const SceneLines& lines : scene.lines) collect(lines, view, blended);
        const auto farther = [](const Blended& a, const Blended& b) {
            return a.nearness < b.nearness;
        };
        std::ranges::stable_sort(blended, farther);
        for (const Blended& item : blended) draw(canvas, item);
        Image image = canvas.image();
        if (is_cancelled(progress_)) return cancelled("drawing");
        return image;
    }

private:
    static void draw_surface(Canvas& canvas, const SceneSurface& surface, const View& view,
                             const Lamps& lamps, std::vector<Blended>& blended)
    {
        const Shading shading(surface, view, lamps);
        const auto on_screen = [&](const Vec3& position) {
            ScreenPoint at = view.project(position);
            at.nearness *= 1.0 + surface.lift;
            return at;
        };
        std::vector<ScreenPoint> seen;
        for (const Vec3& position : surface.positions) seen.push_back(on_screen(position));
        const auto add = [&](const std::array<ScreenVertex, 3>& corners) {
            if (surface.opacity >= 1.0F) {
                canvas.draw_triangle(corners);
                return;
            }
            const auto& [a, b, c] = corners;
            const double middle = (a.point.nearness + b.point.nearness + c.point.nearness) / 3.0;
            blended.push_back(
                {middle, Pane{{a.point, b.point, c.point}, a.color, surface.opacity}});
        };
        for (const TriangleCorners& numbers : surface.triangles) {
            const std::array<Color, 3> colors = {
                shading.corner(numbers, 0), shading.corner(numbers, 1), shading.corner(numbers, 2)};
            const Triangle triangle = {{surface.positions[numbers[0]],
                                        surface.positions[numbers[1]],
                                        surface.positions[numbers[2]]}};
            if (is_in_front(view, triangle)) {
                add({{{seen[numbers[0]], colors[0]},
                      {seen[numbers[1]], colors[1]},
                      {seen[numbers[2]], colors[2]}}});
                continue;
            }
            const VisiblePart part = visible_part(view, triangle);
            std::array<ScreenVertex, 4> cut;
            for (std::size_t i = 0; i < part.count; ++i)
                cut[i] = {on_screen(part.position(triangle, i)), part.color(colors, i)};
            if (part.count >= 3) add({cut[0], cut[1], cut[2]});
            if (part.count == 4) add({cut[0], cut[2], cut[3]});
        }
    }

    static void collect(const SceneLines& lines, const View& view, std::vector<Blended>& blended)
    {
        constexpr double lift = 2e-3; // over the surface that a line lies on
        for (const auto& [from, to] : lines.segments) {
            const auto part = visible_part(view, from, to);
            if (!part) continue;
            const ScreenPoint a = view.project((*part)[0]);
            const ScreenPoint b = view.project((*part)[1]);
            const LineStyle style = {.width = lines.width, .opacity = lines.opacity, .lift = lift};
            blended.push_back(
                {0.5 * (a.nearness + b.nearness) * (1.0 + lift), Stroke{a, b, lines.color, style}});
        }
    }

    static void draw(Canvas& canvas, const Blended& item)
    {
        if (const Pane* const pane = std::get_if<Pane>(&item.what); pane != nullptr) {
            canvas.blend_triangle(pane->corners, pane->color, pane->opacity);
            return;
        }
        const auto& stroke = std::get<Stroke>(item.what);
        canvas.draw_line(stroke.from, stroke.to, stroke.color, stroke.style);
    }

    const Progress* progress_;
};

} // namespace

std::unique_ptr<Renderer> make_software_renderer(const Progress* progress)
{
    return std::make_unique<SoftwareRenderer>(progress);
}

} // namespace proxima
