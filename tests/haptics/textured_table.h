// A table to feel textures on.
#pragma once

#include "haptics/force/surface_renderer.h"
#include "haptics/force/surface_texture.h"
#include "haptics/height_images.h"
#include "haptics/servo_tick.h"
#include "haptics/surface/contact_surface.h"
#include "octree/small_meshes.h"

namespace proxima::testing {

inline constexpr double stiffness = 500;
inline const DeviceLimits omni = *find_device("omni");

inline DeviceState state_at(const Vec3& position, const Vec3& velocity = Vec3::Zero())
{
    DeviceState state;
    state.pose.translation = position;
    state.velocity = velocity;
    return state;
}

/// A renderer of the upper face of a cube of a metre of the device, z = 0.
class Table {
public:
    explicit Table(const RenderOptions& options, const DeviceLimits& device = omni,
                   double units_per_metre = 1)
        : mesh_(cube_mesh(Vec3(0, 0, -0.5 * units_per_metre), 0.5 * units_per_metre)),
          surface_(mesh_), renderer_(make_surface_renderer(
                               surface_, {units_per_metre, Vec3::Zero()}, device, options))
    {}

    /// Moves there straight, with the velocity of that.
    const RenderTick& go(const Vec3& position)
    {
        const Vec3 velocity = started_ ? Vec3((position - before_) / tick_seconds) : Vec3(0, 0, 0);
        started_ = true;
        before_ = position;
        return renderer_.tick(state_at(position, velocity), tick_seconds);
    }
    /// Rests above the table until contacts are forgotten and all ramps are over.
    void rest(const Vec3& position)
    {
        for (int tick = 0; tick < 400; ++tick) go(position);
    }
    [[nodiscard]] const HapticRenderer& renderer() const { return renderer_; }
    [[nodiscard]] HapticRenderer& renderer() { return renderer_; }
    [[nodiscard]] const TextureReport& report() const
    {
        return parts_of(renderer_).texture().report();
    }

private:
    TriangleMesh mesh_;
    MeshContactSurface surface_;
    HapticRenderer renderer_;
    Vec3 before_ = Vec3::Zero();
    bool started_ = false;
};

inline RenderOptions with_texture(const SurfaceTexture& texture, RenderOptions options)
{
    options.texture = texture;
    return options;
}

/// A texture of bumps, not along any axis.
inline SurfaceTexture bumpy(BumpShape shape)
{
    // The image has grey values at random, 2 mm apart.
    return {.bump = {.shape = shape,
                     .amplitude = 6e-5,
                     .wavelength = shape == BumpShape::image ? 0.016 : 0.004,
                     .direction = Vec3(1, 0.3, 0.2),
                     .image = random_image(11, 8, 8)}};
}

} // namespace proxima::testing
