// Feeds files with right checksums and any content to the loader of recordings of tools, and replays the
// first ticks of what it accepts, as `proxima touch --tool --device replay:FILE` does: forces and torques
// are finite and within the device's limits. Whatever the fingerprints say, a small cube touches a cube.
#include "base/binary_file.h"
#include "base/check.h"
#include "exact_copy.h"
#include "haptics/tool/tool_recording.h"
#include "proxima/mesh_index.h"
#include "proxima/sample_meshes.h"
#include "proxima/tool_renderer.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

using namespace proxima;

namespace {

TriangleMesh small_cube()
{
    const TriangleMesh cube = *sample_mesh("cube");
    std::vector<Vec3> positions(cube.positions().begin(), cube.positions().end());
    for (Vec3& position : positions) position *= 0.05;
    return *make_triangle_mesh(std::move(positions),
                               {cube.triangles().begin(), cube.triangles().end()});
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    constexpr std::size_t most_ticks = 32;
    static const MeshIndex cube = *build_mesh_index(*sample_mesh("cube"));
    static const MeshIndex tool = *build_mesh_index(small_cube());
    const auto copy = testing::exact_copy(data, size);
    reseal_binary_file({copy.get(), size});
    const auto recording = load_tool_recording({copy.get(), size}, copy, "fuzz");
    if (!recording) {
        PROXIMA_CHECK(!recording.error().message.empty());
        PROXIMA_CHECK(!recording.error().where.empty());
        return 0;
    }
    const ToolRecordingSettings& settings = recording->settings;
    const ToolObject object = {cube, {}};
    auto renderer = make_tool_renderer(tool, std::span(&object, 1), settings.map, settings.device(),
                                       settings.render);
    if (!renderer) return 0; // a clearance that is too small for the model, dynamic friction, ...
    const std::size_t ticks = std::min(recording->ticks.size(), most_ticks);
    for (std::size_t i = 0; i < ticks; ++i) {
        const DeviceState state = device_state(recording->ticks[i]);
        const ToolTick& tick = renderer->tick(state, settings.tick_seconds);
        PROXIMA_CHECK(tick.force.allFinite() && tick.torque.allFinite());
        PROXIMA_CHECK_LE(tick.force.norm(), settings.max_force);
        PROXIMA_CHECK_LE(tick.torque.norm(), settings.max_torque);
        (void)same_response(recorded(state, tick), recording->ticks[i]);
    }
    return 0;
}
