// One tick of haptic rendering: from where the device is to the force that it gets.
//
//     auto mesh = read_mesh("bunny.obj");
//     auto index = build_mesh_index(*mesh);
//     const DeviceLimits& limits = device.info().limits;
//     const WorkspaceMap map = fit_workspace(bounding_box(*mesh), limits.workspace_radius);
//     auto renderer = make_haptic_renderer(*index, map, limits);    // Result<HapticRenderer>
//     auto input = make_device_input(device.info());                // guards the input (device.h)
//     device.run({.rate = 1000}, [&](std::uint64_t) {
//         renderer->tick(input->accept(device.read()), 1e-3);
//         device.write(input->command(*renderer));
//         return Flow::proceed;
//     });
//
//     device -> model's frame -> proxy -> spring and damper -> passivity -> ramps, clamp, slew
//
// The proxy is where the finger would be if it could not enter the object: a point (god-object,
// [zilles-1995]) or a sphere ([ruspini-1997]) that slides over the surface as near to the device as
// it can come, with a friction cone ([melder-2004]). It never passes a triangle, whichever way
// triangles face and however thin a wall is. A spring pulls the device to it.
//
// Bad input never reaches the force: a position that is not finite is replaced by the last one, and
// the force fades. After a jump that no hand makes the proxy follows from where it was, so it stays
// on its side of every surface, and the force ramps up.
#pragma once

#include "proxima/device.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/touch_scene.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace PROXIMA_EXPORT proxima {

class MeshIndex;
class SurfaceRenderer;

/// From the device's metres to the model's units and back: a point p of the device is
/// center + units_per_metre * p of the model.
struct WorkspaceMap {
    double units_per_metre = 1;
    Vec3 center = Vec3::Zero(); ///< the model's point at the middle of the workspace

    [[nodiscard]] Vec3 to_model(const Vec3& device) const noexcept
    {
        return center + units_per_metre * device;
    }
    [[nodiscard]] Vec3 to_device(const Vec3& model) const noexcept
    {
        return (model - center) / units_per_metre;
    }
};

/// The share of the workspace's radius that the model takes; the rest is for moving round it.
inline constexpr double workspace_share = 0.6;

/// Fits the box into that share of the workspace, centred. \pre the box is not empty, radius > 0
[[nodiscard]] inline WorkspaceMap fit_workspace(const Box& box, double workspace_radius) noexcept
{
    const double half = box.extent().norm() / 2;
    return {half > 0 ? half / (workspace_share * workspace_radius) : 1.0, box.center()};
}

/// The spring, the damper and the guards of the force.
struct ForceOptions {
    double stiffness = 500;      ///< K, N/m; at most the device's
    double damping = 1;          ///< B, N s/m; at most the device's
    double max_slew = 2000;      ///< N/s: from nothing to a Phantom Omni's 3.3 N in 1.65 ms
    double start_seconds = 0.25; ///< ramp up from the first tick
    double loss_seconds = 0.05;  ///< ramp down once the input or surface is lost, and up again
};

/// Whether walls are kept from giving more energy than they took ([hannaford-2002]).
enum class Guard : std::uint8_t {
    off,
    observe, ///< reports what it would do, and leaves the force
    on
};

struct RenderOptions {
    ForceOptions force = {};
    double proxy_radius = 0; ///< m; 0 = a point
    double static_friction = 0.4;
    double dynamic_friction = 0.3; ///< at most static_friction
    Guard guard = Guard::on;
    double max_jump = 0.05; ///< m in a tick: 50 m/s at 1 kHz; beyond it the force ramps up anew
    /// Most moves of the proxy in a tick, twice that with shading: bounds a tick's work. 4 to 48.
    std::size_t max_moves = 12;
    /// On: forces lean towards the smooth normals of bodies that were built with them.
    ForceShading shading = ForceShading::off;
    SurfaceTexture texture = {}; ///< of surfaces that have none of their own
};

/// How the surface holds the proxy.
enum class Hold : std::uint8_t { free, sliding, sticking };

/// How the proxy's motion of a tick ended.
enum class SlideEnd : std::uint8_t {
    settled,   ///< nothing nearer to the device can be reached
    limited,   ///< the tick's moves are used up: the next tick goes on
    overloaded ///< more triangles are near than there is memory for: the proxy stays where it is
};

/// The fault of a tick's input: a position that is not finite, or beyond 1e150 in the model's units,
/// a tool's beyond 2^40 clearances; one farther from the last than max_jump.
enum class InputFault : std::uint8_t { none, not_finite, jumped };

/// A point of the surface that holds the proxy back. In the model's units and frame.
struct ContactPoint {
    Vec3 position = Vec3::Zero();
    Vec3 normal = Vec3::UnitZ(); ///< from the surface to the proxy, of length 1
    TriangleId triangle{};       ///< the lowest of those touched there; in a scene see object_of()
    double pressure = 0;         ///< part of the spring's stretch along the normal
};

/// Everything about one tick. The proxy's numbers are in the model's units and frame.
struct RenderTick {
    Vec3 position = Vec3::Zero(); ///< of the device as it was used, m
    Vec3 force = Vec3::Zero();    ///< N, what the device gets
    Vec3 spring = Vec3::Zero();   ///< N, before the guards
    Vec3 texture = Vec3::Zero();  ///< N, what the surface's texture changes in `spring`
    double tap = 0;               ///< N, along the normal, after an impact

    Vec3 proxy = Vec3::Zero();  ///< its centre
    Vec3 anchor = Vec3::Zero(); ///< what the spring pulls the device to; the device where free
    Hold hold = Hold::free;
    Vec3 normal = Vec3::Zero(); ///< of all contacts together, of length 1; zero where free
    double depth = 0;           ///< of the device below the position of a frictionless proxy
    bool is_placed = true;      ///< false: no free position is near, or the device began inside a
                                ///< closed mesh; nothing is touched
    std::array<ContactPoint, 3> contacts = {};
    std::size_t contact_count = 0; ///< of the frictionless proxy
    std::size_t moves = 0;         ///< straight moves of the proxy
    SlideEnd slide_end = SlideEnd::settled;

    InputFault fault = InputFault::none;
    InputCondition condition = InputCondition::well; ///< of the state that the tick was given
    Vec3 surface_velocity = Vec3::Zero();            ///< m/s, of what is touched in a scene
    bool squeezed = false; ///< moving objects left the proxy no free position
};

/// Whether the surface of a tick is available. An index or a scene always is; lost is for surfaces
/// that another thread hands over and that came too late.
enum class Patch : bool { available, lost };

/// Renders for one device. One thread. noexcept, no allocation.
class HapticRenderer {
public:
    HapticRenderer(HapticRenderer&& other) noexcept;
    HapticRenderer& operator=(HapticRenderer&& other) noexcept;
    ~HapticRenderer();

    /// The options as limited by the device.
    [[nodiscard]] const RenderOptions& options() const noexcept;
    [[nodiscard]] const WorkspaceMap& map() const noexcept;

    /// One tick of `seconds`. The first one with a finite position places the proxy there, or at
    /// the free position nearest to it; inside a closed mesh nothing is felt until the device is
    /// out. The force fades while the patch is lost or the state's condition is not `well`. A few
    /// microseconds. \pre seconds > 0
    const RenderTick& tick(const DeviceState& state, double seconds,
                           Patch patch = Patch::available) noexcept;

    /// Starts anew with the same options: the next tick places the proxy as the first one did, the
    /// force ramps up from zero, and the guard has seen nothing. Objects of a scene stay where they
    /// are.
    void reset() noexcept;

    /// What the last tick returned.
    [[nodiscard]] const RenderTick& last() const noexcept;

    /// The proxy's positions in the last tick, with straight moves between them.
    [[nodiscard]] std::span<const Vec3> path() const noexcept;

private:
    friend class RendererAccess;
    explicit HapticRenderer(std::unique_ptr<SurfaceRenderer> renderer) noexcept;

    std::unique_ptr<SurfaceRenderer> renderer_; ///< not null but after a move
};

/// Renders a mesh at rest, whose index it shares. Forces have the same bits for an index with and
/// without lists (with_lists); lists shorten the median tick of some motions, not the slowest ticks.
/// Options are limited to what the device can take. Errors: invalid_argument, naming the number that
/// is out of range; invalid_mesh (an empty index, or one larger than 1e150), broken_invariant (a
/// crafted index file), and those of with_signs, which is called for an index without signs.
/// O(triangles).
[[nodiscard]] Result<HapticRenderer> make_haptic_renderer(const MeshIndex& index,
                                                          const WorkspaceMap& map,
                                                          const DeviceLimits& device,
                                                          const RenderOptions& options = {});

/// Renders a scene, which must outlive the renderer, and whose objects each tick moves on for this
/// tool. Any thread, also while other renderers of the scene run. Materials are those of its bodies.
/// Error invalid_argument, as above, and where the scene has max_scene_tools renderers.
[[nodiscard]] Result<HapticRenderer> make_haptic_renderer(TouchScene& scene,
                                                          const WorkspaceMap& map,
                                                          const DeviceLimits& device,
                                                          const RenderOptions& options = {});

} // namespace proxima
