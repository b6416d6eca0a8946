// Haptic rendering with six degrees of freedom: a rigid tool that touches objects, its force and its
// torque (thesis sections 5.1 and 5.2 together).
//
//     auto tool = build_mesh_index(*read_mesh("tool.obj"));      // its origin is the device's tip
//     auto bunny = build_mesh_index(*read_mesh("bunny.obj"));
//     const ToolObject objects[] = {{.index = *bunny}};          // or a TouchScene, whose objects move
//     auto renderer = make_tool_renderer(*tool, objects, map, limits);    // Result<ToolRenderer>
//     device.run({.rate = 1000}, [&](std::uint64_t) {
//         renderer->tick(input->accept(device.read()), 1e-3);
//         device.write(input->command(*renderer));              // device.h
//         return Flow::proceed;
//     });
//
//     device ─▶ proxy: the pose nearest to the device's in which the tool enters nothing
//                 └─▶ springs for displacement and rotation ─▶ passivity ─▶ ramps, limits, slew
//
// The proxy moves by Gauss' principle of least constraint ([ortega-2007]): of all motions that the
// contacts allow it makes the one that leaves the least energy in the springs. Between two poses the
// tool passes no triangle, however thin the wall and however fast the hand. Friction is Coulomb's law at
// each contact; the tool sticks and slides as the point of a HapticRenderer does.
#pragma once

#include "proxima/device.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/haptic_renderer.h"
#include "proxima/mesh_index.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace PROXIMA_EXPORT proxima {

class ToolSurfaceRenderer;
class TouchScene;

/// An object at rest, in a pose in the scene.
struct ToolObject {
    MeshIndex index;
    RigidTransform pose = {}; ///< the renderer makes it rigid, by make_rigid_transform
};

struct ToolRenderOptions {
    ForceOptions force = {}; ///< of displacements; ramps also of the torque
    /// K_theta, N m/rad; 0 = as stiff as the force half the tool's reach from its origin.
    double torsional_stiffness = 0;
    double torsional_damping = 0; ///< N m s/rad
    double static_friction = 0.4;
    double dynamic_friction = 0.3; ///< at most static_friction
    double max_torque_slew = 200;  ///< N m/s
    /// Whether springs that are too stiff are damped and softened, force and torque together. A turn
    /// counts as the displacement that it makes at 1/32 m (docs/haptic_tools.md).
    Guard guard = Guard::on;
    /// m between the tool and the objects where they touch; half of it is always kept. At least 2^-30
    /// of the scene's size.
    double clearance = 1e-5;
    double max_jump = 0.05; ///< m in a tick: 50 m/s at 1 kHz; beyond it the force ramps up anew
    double max_turn = 0.5;  ///< rad in a tick: likewise
    /// Most moves of the proxy in a tick: bounds a tick's work. 1 to 32.
    std::size_t max_moves = 4;
    /// Most work in a tick, about a microsecond a unit (ToolTick::work); 0 = no bound. A tick that would
    /// take more ends with what it has proven to be free. At least 100.
    std::size_t max_work = 800;
};

/// A point that holds the tool back. In the model's units and frame.
struct ToolContact {
    Vec3 position = Vec3::Zero(); ///< on the object
    Vec3 normal = Vec3::UnitZ();  ///< from the object to the tool, of length 1
    std::uint32_t object = 0;     ///< its number in make_tool_renderer()'s list or in the scene
    TriangleId triangle{};        ///< of the object
    TriangleId tool_triangle{};
    double force = 0; ///< N, along the normal, of the springs without damping
};

/// How the proxy's motion of a tick ended.
enum class ToolEnd : std::uint8_t {
    settled, ///< no pose nearer to the device can be reached
    limited, ///< moves are used up, or an object is behind (haptic_tools.md): the next tick goes on
    cut_short, ///< likewise its work, max_work: the proxy moved only as far as was proven by then
    overloaded ///< more triangles are near than there is memory for: the proxy stays where it is
               ///< until the device is free: then the force fades, and the tool is placed anew
};

/// Everything about one tick.
struct ToolTick {
    RigidTransform device = {};          ///< as it was used; metres
    Vec3 force = Vec3::Zero();           ///< N, what the device gets
    Vec3 torque = Vec3::Zero();          ///< N m, about the device's tip; zero without torques
    Vec3 spring_force = Vec3::Zero();    ///< N, before the guards
    Vec3 spring_torque = Vec3::Zero();   ///< N m, before the guards, also without torques
    RigidTransform proxy = {};           ///< of the tool, in the model's units and frame
    double force_scale = 1;              ///< 0 to 1: the ramps
    bool is_placed = true;               ///< false: the device began inside; nothing is touched
    Hold hold = Hold::free;              ///< `sliding` in contact without friction
    std::array<ToolContact, 6> contacts; ///< what holds the proxy back
    std::size_t contact_count = 0;
    std::size_t moves = 0;          ///< of the proxy
    std::size_t near_triangles = 0; ///< pairs that were near
    std::size_t work = 0;           ///< about microseconds, the same on every machine
    ToolEnd end = ToolEnd::settled;
    InputFault fault = InputFault::none;
    InputCondition condition = InputCondition::well; ///< of the state that the tick was given
};

/// Renders one tool for one device. One thread. noexcept, no allocation.
class ToolRenderer {
public:
    ToolRenderer(ToolRenderer&& other) noexcept;
    ToolRenderer& operator=(ToolRenderer&& other) noexcept;
    ~ToolRenderer();

    /// The options as limited by the device.
    [[nodiscard]] const ToolRenderOptions& options() const noexcept;
    [[nodiscard]] const WorkspaceMap& map() const noexcept;

    /// One tick of `seconds`. A tool that begins in an object, or within half the clearance of one,
    /// feels nothing until it is out. Force and torque fade while the state's condition is not
    /// `well`. \pre seconds > 0
    const ToolTick& tick(const DeviceState& state, double seconds) noexcept;

    /// Starts anew with the same options: the next tick places the tool as the first one did, and the
    /// guard has seen nothing.
    void reset() noexcept;

    /// What the last tick returned.
    [[nodiscard]] const ToolTick& last() const noexcept;

    /// The proxy's poses in the last tick: from each to the next the tool's origin moves straight and
    /// the tool turns about one axis. After jumps it may turn by more than half a turn, or a whole one:
    /// the poses alone do not tell.
    [[nodiscard]] std::span<const RigidTransform> path() const noexcept;

private:
    friend class ToolSurfaceRenderer;
    explicit ToolRenderer(std::unique_ptr<ToolSurfaceRenderer> renderer) noexcept;

    std::unique_ptr<ToolSurfaceRenderer> renderer_; ///< not null but after a move
};

/// Renders a tool that touches objects at rest, whose indexes it shares. The tool's mesh is in the
/// model's unit, and its origin is the device's tip. Its inside and that of the objects is told as
/// find_containment tells it; open meshes have none. Options are limited to what the device can take;
/// without DeviceLimits::max_torque it gets the force alone. Errors: invalid_argument, naming the
/// number that is out of range; invalid_mesh (an empty index, more than 1e150 in size), and those of
/// with_slabs, build_topology and build_enclosure. O(triangles log triangles).
[[nodiscard]] Result<ToolRenderer> make_tool_renderer(const MeshIndex& tool,
                                                      std::span<const ToolObject> objects,
                                                      const WorkspaceMap& map,
                                                      const DeviceLimits& device,
                                                      const ToolRenderOptions& options = {});

/// Renders a tool that touches a scene, which must outlive the renderer, and whose objects each tick
/// moves on for this tool. Objects have the friction of their materials, or without one that of the
/// options; stiffness and damping are those of the options. A tool feels the bodies that objects were
/// given last: later exchange() and deform(), and textures, are for points, and TouchScene::add() fails
/// until the renderer ends. Refits get an index of their own here. An object that would squeeze the tool
/// stays behind for it, as ToolEnd::limited tells, until there is room. Any thread, also while other
/// renderers of the scene run. Errors: as above, those of build_mesh_index for refits, and
/// invalid_argument where the scene has max_scene_tools renderers.
[[nodiscard]] Result<ToolRenderer> make_tool_renderer(const MeshIndex& tool, TouchScene& scene,
                                                      const WorkspaceMap& map,
                                                      const DeviceLimits& device,
                                                      const ToolRenderOptions& options = {});

} // namespace proxima
