// Touching in patch mode, as the thesis does (section 5.1): a collision loop sends triangles near
// the device down to the servo loop, which touches these alone.
//
//     servo loop      1,000 Hz   touches the newest patch, and says where it is
//     collision loop    100 Hz   asks the octree for the next one
//     graphics           50 Hz   shows how it is
//
// Beside it, for the account, a proxy that touches the whole model follows the same device.
#pragma once

#include "cli/query_method.h"
#include "haptics/force/contact_force.h"
#include "haptics/loop/patch_exchange.h"
#include "haptics/proxy/contact_cache.h"
#include "haptics/proxy/proxy.h"
#include "haptics/surface/contact_patch.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/result.h"
#include "thesis/haptic_interaction/thesis_patches.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace proxima {

struct TouchModel;

struct PatchSettings {
    int rings = 0;                           ///< the thesis's adjacency depth
    QueryMethod method = QueryMethod::index; ///< what finds the closest feature of rings
    double collision_rate = 100;
};

/// What became of the patches of a session.
struct PatchAccount {
    PatchSettings settings;
    std::uint64_t ticks = 0;
    std::uint64_t patches = 0;
    std::uint64_t incomplete = 0; ///< whose capacity was too small for all triangles
    std::uint64_t triangles = 0;  ///< of all patches
    std::uint64_t largest = 0;
    std::uint64_t model_triangles = 0;
    std::uint64_t touching_ticks = 0; ///< of the proxy on the whole model
    std::uint64_t missed_ticks = 0;   ///< in which it touched a triangle that the patch lacks
    std::uint64_t apart_ticks = 0;  ///< in which the two proxies were more than a micrometre apart
    std::uint64_t oldest_ticks = 0; ///< the oldest patch that was touched
    std::uint64_t waited_ticks = 0; ///< before the first patch came: there was no force
    std::uint64_t lost_ticks = 0;   ///< without a patch young enough: the force faded
    std::uint64_t late_collisions = 0; ///< deadlines that the collision loop missed
    LatencyHistogram tick;             ///< of computing forces by these patches, ns
};

/// Patches of one session: the servo thread's, but for the constructor, finish() and the loop that
/// it runs in a thread of its own.
class PatchTouch {
public:
    /// Paced sessions have a collision thread; in others the servo thread makes each patch when it
    /// is due, at the end of a tick, and touches it a period later. Refers to model and properties.
    PatchTouch(const TouchModel& model, const PatchSettings& settings, const WorkspaceMap& map,
               const RenderOptions& render, const SurfaceProperties* properties,
               double tick_seconds, Pace pace);
    PatchTouch(const PatchTouch&) = delete;
    PatchTouch& operator=(const PatchTouch&) = delete;
    ~PatchTouch();

    /// What the session's proxy touches.
    [[nodiscard]] const ContactSurface& surface() const noexcept { return patch_; }

    /// Takes the newest patch: what patch mode adds to a tick's work. noexcept, no allocation.
    [[nodiscard]] Patch begin_tick() noexcept;

    /// Says where device and proxy are, keeps account and, without a collision thread, does its
    /// work. noexcept, no allocation.
    void end_tick(const RenderTick& rendered) noexcept;

    /// Ends the collision thread.
    [[nodiscard]] PatchAccount finish();

private:
    [[nodiscard]] bool make(ContactPatch& patch, const ServoPosition& position) noexcept;
    void compare(const RenderTick& rendered) noexcept;
    [[nodiscard]] bool has(const Contact& contact) noexcept;

    const IndexContactSurface& whole_;
    WorkspaceMap map_;
    PatchAccount account_;
    RingPatches rings_;
    std::optional<ThesisPatches> by_thesis_; ///< where the thesis's octree is asked
    PatchContactSurface patch_;
    Proxy expected_;
    ContactCache looked_up_; ///< of patches, for the account
    std::vector<ContactTriangle> near_;
    bool placed_ = false;
    PatchExchange exchange_;
    std::vector<ContactPatch> due_; ///< unpaced: the one that is touched, and the next
    std::size_t making_ = 0;
    bool made_ = false; ///< unpaced: the next one was made
    std::uint64_t ticks_per_patch_ = 10;
    const ContactPatch* used_ = nullptr;
    std::uint64_t tick_ = 0;
    ServoPosition position_;
    std::atomic<bool> ending_{false};
    ServoStatistics collision_;
    std::thread collision_thread_;
};

/// "rings 2".
[[nodiscard]] std::string name_of(const PatchSettings& settings);

/// "1,2,3": the kinds in their order. Error invalid_argument.
[[nodiscard]] Result<std::vector<PatchSettings>> parse_patch_kinds(const std::string& text);

/// A table, a line for each account.
[[nodiscard]] std::string patch_table(const std::vector<PatchAccount>& accounts);
[[nodiscard]] nlohmann::ordered_json patch_json(const std::vector<PatchAccount>& accounts);

} // namespace proxima
