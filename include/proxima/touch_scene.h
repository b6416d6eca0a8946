// Objects to touch, which move and change while they are touched.
//
//     TouchScene scene({Vec3(-1, -1, -1), Vec3(1, 1, 1)});          // objects stay within this box
//     auto body = build_touch_body(mesh, {.material = SurfaceMaterial{.stiffness = 300}});
//     const ObjectId cup = *scene.add(*body, pose);                 // before the first tick
//     auto renderer = make_haptic_renderer(scene, map, limits);     // its ticks move the objects
//     auto other = make_haptic_renderer(scene, other_map, limits);  // another tool, in its own thread
//     scene.move(cup, {.pose = next, .seconds = 0.02});             // any time, by another thread
//     scene.exchange(cup, *other_body);                             // any time, by another thread
//     auto bent = refit_touch_body(*body, positions);               // any thread, any time
//     scene.deform(cup, *bent, 1.0 / 60);                           // any time, by another thread
//     auto channel = open_engine_channel("udp:4712");               // moved by another program
//
//     application ──motions, bodies──▶ snapshots ──▶ servo loops     none waits for another
//
// All objects together are one surface: a corner that several of them form is a corner. Nothing is
// passed while objects move or change their shape, however thin and fast they are; touched objects
// carry the proxy along.
//
// Up to 8 renderers touch one scene, each in a servo loop of its own, and may be made and destroyed
// while others run. Poses depend on the scene's time, the sum of the ticks of the tool that is ahead:
// all tools see the same pose at the same time. A loop that loses ticks lags behind the others by at
// most 3 ms, or three of its ticks where these are longer.
//
// Lengths are in the scene's unit, which is the model's unit of the renderer's WorkspaceMap.
#pragma once

#include "proxima/execution.h"
#include "proxima/export.h"
#include "proxima/geometry.h"
#include "proxima/result.h"
#include "proxima/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace PROXIMA_EXPORT proxima {

class ContactBody;
class EngineLink;
class HapticRenderer;
class HeightSamples;
class MeshIndex;
class SceneViews;
struct DeviceState;

/// Stiffness, damping and friction of a body, limited by what the device can take.
struct SurfaceMaterial {
    double stiffness = 500;        ///< K, N/m
    double damping = 1;            ///< B, N s/m
    double static_friction = 0.4;  ///< mu_s
    double dynamic_friction = 0.3; ///< mu_d, at most mu_s
};

/// A HeightImage has at most so many rows and columns.
inline constexpr std::size_t most_image_side = 2048;

/// Heights as the grey values of a picture, row by row from the top: 0 is deepest, 1 is the surface.
/// Immutable; copies share the storage; any thread.
class HeightImage {
public:
    [[nodiscard]] std::size_t columns() const noexcept;
    [[nodiscard]] std::size_t rows() const noexcept;
    [[nodiscard]] std::span<const float> samples() const noexcept;
    [[nodiscard]] const HeightSamples& parts() const noexcept { return *parts_; }

    // Copies only: a moved-from image would have no samples.
    HeightImage(const HeightImage&) noexcept = default;
    HeightImage& operator=(const HeightImage&) noexcept = default;
    ~HeightImage() = default;

private:
    friend Result<HeightImage> build_height_image(std::span<const float> samples,
                                                  std::size_t columns);
    explicit HeightImage(std::shared_ptr<const HeightSamples> parts) noexcept;

    std::shared_ptr<const HeightSamples> parts_; ///< never null
};

/// Copies the samples, and finds their greatest slope and curvature. About 0.1 us per sample. Error
/// invalid_argument: no samples, no whole number of rows, a side above most_image_side, a sample that
/// is not from 0 to 1.
[[nodiscard]] Result<HeightImage> build_height_image(std::span<const float> samples,
                                                     std::size_t columns);

/// The pattern of a height field.
enum class BumpShape : std::uint8_t {
    none,
    grating, ///< parallel waves along a direction
    dimples, ///< waves along all three axes of the object's frame
    noise,   ///< smooth and at random: the wavelength is that of its lattice
    image    ///< a HeightImage, tiled, and projected along a direction; the wavelength is its width
};

/// Grooves below the triangles, by a function of the position in the object's frame: no texture
/// coordinates. Crests are where the triangles are. Lengths are in metres of the device, whatever the
/// model's units.
///
/// An image is seen upright and not mirrored by who looks against `direction`. Up in it is the object's
/// y axis where z is the direction's largest component, else z. The lower left corner of a tile is at the
/// object's origin. Surfaces that lean away from the direction have the image stretched.
struct Bump {
    BumpShape shape = BumpShape::none;
    double amplitude = 0;                  ///< m, half the depth of a groove: 0 to 0.01
    double wavelength = 0.004;             ///< m: 1e-4 to 1
    Vec3 direction = Vec3::UnitX();        ///< of a grating and of an image; of any length but 0
    std::optional<HeightImage> image = {}; ///< what BumpShape::image needs and others ignore

    [[nodiscard]] bool any() const noexcept { return shape != BumpShape::none && amplitude > 0; }
};

/// A spring along the surface from where the device sticks: beyond max_force it sticks elsewhere.
struct StickSlip {
    double stiffness = 0; ///< N/m; at most 200 and a quarter of the device's
    double max_force = 0; ///< N; at most the device's

    [[nodiscard]] bool any() const noexcept { return stiffness > 0 && max_force > 0; }
};

/// A force along the normal after an impact at v m/s, gain v exp(-decay t) sin(2 pi frequency t),
/// of at most half the device's greatest force ([okamura-2001]).
struct Tap {
    double gain = 0;        ///< N s/m; at most most_tap_gain
    double frequency = 150; ///< Hz: 10 to 400
    double decay = 80;      ///< 1/s: 10 to 1000

    [[nodiscard]] bool any() const noexcept { return gain > 0; }
};

/// N s/m: a tap at 1 m/s then has 20 N, as much as the strongest known device.
inline constexpr double most_tap_gain = 20;

/// What a surface feels like beside stiffness and friction. Nothing by default. Strengths are limited
/// by what the device can take, the amplitude also by stiffness and wavelength (docs/haptics.md).
struct SurfaceTexture {
    Bump bump = {};
    double viscosity =
        0; ///< N s/m, against motion along the surface; at most a quarter of what the
           ///< device takes
    StickSlip stick_slip = {};
    Tap tap = {};

    [[nodiscard]] bool any() const noexcept
    {
        return bump.any() || viscosity > 0 || stick_slip.any() || tap.any();
    }
};

/// Whether forces lean towards the normals of the smooth surface that a mesh stands for.
enum class ForceShading : bool { off, on };

struct TouchBodyOptions {
    std::optional<SurfaceMaterial> material = {}; ///< none: the renderer's own settings
    std::optional<SurfaceTexture> texture = {};   ///< none: the renderer's own
    ForceShading shading = ForceShading::off; ///< on: with smooth normals, for renderers with it on
    Execution execution = {};
};

/// A mesh with all that touching it takes. Immutable; copies share the storage; any thread.
class TouchBody {
public:
    /// The mesh that it was built from.
    [[nodiscard]] const TriangleMesh& mesh() const noexcept;

    // Copies only: a moved-from body would have no mesh.
    TouchBody(const TouchBody&) noexcept = default;
    TouchBody& operator=(const TouchBody&) noexcept = default;
    ~TouchBody() = default;

private:
    friend class TouchAccess;
    explicit TouchBody(std::shared_ptr<const ContactBody> body) noexcept;

    std::shared_ptr<const ContactBody> body_; ///< never null
};

/// Builds an index of the mesh, without lists, and a body. Errors: those of build_topology,
/// build_mesh_index and with_signs; invalid_argument for materials that are not finite, negative,
/// or of more dynamic than static friction, and for textures that are out of range.
[[nodiscard]] Result<TouchBody> build_touch_body(TriangleMesh mesh,
                                                 const TouchBodyOptions& options = {});

/// Builds a body from an index, built or loaded, whose storage the body shares. Forces
/// have the same bits with and without lists (with_lists). Lists shorten the median tick of some
/// motions, not the slowest ticks, and take more than a hundred times as long to build as the index.
/// Errors also: invalid_mesh or broken_invariant where the index does not hold such a mesh.
[[nodiscard]] Result<TouchBody> build_touch_body(const MeshIndex& index,
                                                 const TouchBodyOptions& options = {});

/// The body with its vertices elsewhere, one position for each vertex of body.mesh(): with the same
/// triangles, material, texture and shading. `body` stays as it was, and may itself be a refit. A refit has no
/// inside: a proxy that starts anew is not moved out of it. Errors: invalid_argument (another number
/// of positions), invalid_mesh (NaN, larger than 1e150), cancelled. About 50 ns
/// per triangle, more with shading.
[[nodiscard]] Result<TouchBody> refit_touch_body(const TouchBody& body,
                                                 std::span<const Vec3> positions,
                                                 const Execution& execution = {});

/// The number of an object in its scene, from 0, in the order in which objects were added.
enum class ObjectId : std::uint32_t {};

[[nodiscard]] constexpr std::uint32_t to_index(ObjectId id) noexcept
{
    return static_cast<std::uint32_t>(id);
}

/// No scene has more objects.
inline constexpr std::size_t max_scene_objects = 64;

/// No scene has more renderers at a time.
inline constexpr std::size_t max_scene_tools = 8;

/// A triangle of a scene is named by one number: the bits of its id in its object's mesh, and above
/// them those of the object. So bodies in scenes have at most 2^26 triangles.
inline constexpr unsigned scene_triangle_bits = 26;

[[nodiscard]] constexpr TriangleId scene_triangle(ObjectId object, TriangleId triangle) noexcept
{
    return TriangleId{to_index(object) << scene_triangle_bits | to_index(triangle)};
}
/// The object of a triangle that a scene names, as RenderTick::contacts do.
[[nodiscard]] constexpr ObjectId object_of(TriangleId scene_triangle) noexcept
{
    return ObjectId{to_index(scene_triangle) >> scene_triangle_bits};
}
/// That triangle's id in the object's mesh.
[[nodiscard]] constexpr TriangleId triangle_of(TriangleId scene_triangle) noexcept
{
    return TriangleId{to_index(scene_triangle) & ((1U << scene_triangle_bits) - 1)};
}

/// The motion of an object: to a pose within a time, and from there on at a velocity. Servo loops move
/// its origin evenly along a straight line and turn it evenly about one axis: a mesh far from its own
/// origin swings aside between two poses that turn it, so centre its vertices first.
///
/// An application that updates poses at 50 Hz sets `seconds` to 0.02: the object lags by a period and
/// never jumps. One that knows velocities gives them, and it coasts on until the next message.
struct ObjectMotion {
    RigidTransform pose = {};     ///< where it will be
    double seconds = 0;           ///< until it has that pose; 0 = at once, for the next tick
    Vec3 velocity = Vec3::Zero(); ///< from then on, of the object's origin, per second
    Vec3 spin = Vec3::Zero();     ///< from then on, radians per second about the scene's axes, at
                                  ///< most 1e4 about each
    double coast_seconds = 0;     ///< how long these velocities last: then the object rests
};

/// What a tick changed.
struct SceneTick {
    bool moved = false;     ///< the pose or the shape of some object
    bool exchanged = false; ///< the body of some object
    double seconds = 0;     ///< by which objects moved on: more than the tick's after lost ticks
};

/// Up to 64 objects. add() before the first tick, and before a ToolRenderer is made; move(), exchange(),
/// deform() and set_material() by one thread for each object, at any time; advance(), pose() and
/// velocity() by the thread of the renderer that was made first; after its end the next that is made
/// takes its place. Renderers are made and destroyed by any thread at any time. A value that moves,
/// while no renderer has it.
class TouchScene {
public:
    /// Objects stay within the bounds, whose size decides how exact positions are: a point proxy
    /// keeps a distance of 2^-30 of it from surfaces. \pre the bounds are not empty
    explicit TouchScene(const Box& bounds);
    TouchScene(TouchScene&& other) noexcept;
    TouchScene& operator=(TouchScene&& other) noexcept;
    ~TouchScene();

    /// Adds an object. Error invalid_argument: after the first tick, while there is a ToolRenderer, too
    /// many objects or triangles, a pose that is not rigid, or an object that reaches out of the
    /// bounds.
    [[nodiscard]] Result<ObjectId> add(const TouchBody& body, const RigidTransform& pose);

    /// Gives an object a motion, which replaces earlier ones and begins where they took it. Wait-free.
    /// Error invalid_argument: numbers that are not finite, negative times, too fast a spin, a pose that
    /// is not rigid, or one that reaches out of the bounds, also while the object coasts; an object
    /// that was not added. A turn on the way to the pose may reach out.
    [[nodiscard]] Status move(ObjectId object, const ObjectMotion& motion);

    /// Gives an object another body from the next tick on. Copies of the old body go once no tool uses
    /// it: with a later exchange or change of shape, with the tool's renderer or with the scene, never
    /// in a servo thread. The force fades and rises anew only if the proxy touched the old body or is
    /// at the new one. Error invalid_argument: out of the bounds where the object is or goes, too many
    /// triangles, an object that was not added.
    [[nodiscard]] Status exchange(ObjectId object, const TouchBody& body);

    /// Gives an object the shape of a refit of its body: within `seconds` each vertex moves evenly
    /// along a straight line of the object's frame from where the body given last had it. The force
    /// does not fade, and the proxy stays where it touches. An application that gives shapes at 60 Hz
    /// sets `seconds` to 1/60. A shape that comes before the last one was reached is begun all the
    /// same: vertices go there from where they are within a tick. Takes effect without waiting, after
    /// O(triangles) in the caller's thread. A shape on its way has no inside. Error invalid_argument: a
    /// body with other triangles than the one given last, a negative time, out of the bounds where the
    /// object is or goes, an object that was not added.
    [[nodiscard]] Status deform(ObjectId object, const TouchBody& body, double seconds);

    /// Gives an object another material than its body's, until the body is exchanged. Each number
    /// changes evenly within `seconds`, so that the force does not jump; where the body has no
    /// material, or with 0, in the next tick. Wait-free. Error invalid_argument: a material that
    /// build_touch_body would refuse, a negative time, an object that was not added.
    [[nodiscard]] Status set_material(ObjectId object, const SurfaceMaterial& material,
                                      double seconds);

    /// Advances all objects by a tick. The first renderer calls it. noexcept, wait-free, no allocation,
    /// nothing freed. \pre seconds > 0
    SceneTick advance(double seconds) noexcept;

    [[nodiscard]] std::size_t object_count() const noexcept;

    /// The pose of an object in this tick of the first renderer. A tool may see it where it was in an
    /// earlier one (haptic_tools.md). noexcept. \pre the object was added
    [[nodiscard]] RigidTransform pose(ObjectId object) const noexcept;

    /// The velocity in the last tick of a point that moves with an object's pose, per second. noexcept.
    /// \pre the object was added
    [[nodiscard]] Vec3 velocity(ObjectId object, const Vec3& point) const noexcept;

private:
    friend class TouchAccess;

    std::unique_ptr<SceneViews> views_; ///< not null but after a move
};

/// Counts of a channel's packets.
struct EngineReport {
    std::uint64_t received = 0;        ///< packets of any kind
    std::uint64_t accepted = 0;        ///< scene packets
    std::uint64_t malformed = 0;       ///< of a wrong size or magic, or with a time out of range
    std::uint64_t other_versions = 0;  ///< of another version of the protocol
    std::uint64_t foreign = 0;         ///< of another engine than the served one
    std::uint64_t duplicated = 0;      ///< with the number of the last one
    std::uint64_t reordered = 0;       ///< with a lower number
    std::uint64_t leapt = 0;           ///< with a number that is too high to follow
    std::uint64_t lost = 0;            ///< missing numbers, in each session from its first
    std::uint64_t sessions = 0;        ///< of engines, one after another
    std::uint64_t motions = 0;         ///< that objects were given
    std::uint64_t materials = 0;       ///< that objects were given
    std::uint64_t refused_objects = 0; ///< of accepted packets: no such object, no rigid pose, ...
    std::uint64_t sent = 0;            ///< touch packets
    std::uint64_t unsent = 0;          ///< touch packets that the system refused
};

/// A channel to an engine in another program, which owns the world: Unity, Unreal, Godot, ROS. It
/// sends where objects are and what they are made of, and gets what is touched, in every tick.
///
///     engine  ──poses, velocities, materials──▶    channel  ──▶ TouchScene     60 to 100 times a second
///     engine  ◀──proxy, anchor, force, contacts──  channel  ◀── HapticRenderer  1,000 times a second
///
///     auto channel = open_engine_channel("udp:4712");                 // or "shm:NAME"
///     each tick:  channel->receive(scene, 1e-3);
///                 const DeviceState& state = input->accept(device.read());
///                 renderer->tick(state, 1e-3);
///                 device.write(input->command(*renderer));
///                 channel->send(*renderer, state);
///
/// docs/engine_channel.md describes the packets byte by byte; engine_client.py and engine_client.c of
/// the examples are the engine's side. The servo thread's. A value that moves.
class EngineChannel {
public:
    EngineChannel(EngineChannel&& other) noexcept;
    EngineChannel& operator=(EngineChannel&& other) noexcept;
    /// Ends the channel and removes the shared memory.
    ~EngineChannel();

    /// Takes the packets that came, and moves objects and changes materials by them: the scene's
    /// objects are left to the engine. Call it before the renderer's tick. Whatever comes, the scene
    /// gets rigid poses within its bounds and materials that build_touch_body takes. noexcept, wait-
    /// free, no allocation, at most 64 packets. \pre seconds > 0
    void receive(TouchScene& scene, double seconds) noexcept;

    /// Sends the last tick. Call it after the device got its force. noexcept, never waits, no
    /// allocation.
    void send(const HapticRenderer& renderer, const DeviceState& state) noexcept;

    [[nodiscard]] const EngineReport& report() const noexcept;

    /// What went wrong, in words; "" for nothing. By the servo thread, outside of ticks.
    [[nodiscard]] std::string trouble() const;

private:
    friend Result<EngineChannel> open_engine_channel(std::string_view name);
    explicit EngineChannel(std::unique_ptr<EngineLink> link) noexcept;

    std::unique_ptr<EngineLink> link_; ///< not null but after a move
};

/// Opens a channel by name:
///     udp:PORT            datagrams of programs on this machine
///     udp:ADDRESS:PORT    also of others, where the address is one of a network
///     shm:NAME            shared memory, for programs of this user; the first one installs a handler of
///                         SIGBUS, for memory that another program shortens, and passes others on
/// Errors: invalid_argument (another name, what the system says, a name or port that is in use).
[[nodiscard]] Result<EngineChannel> open_engine_channel(std::string_view name);

} // namespace proxima
