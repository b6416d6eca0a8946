// The earliest time at which some triangle of a moving mesh is about to touch one of another mesh.
//
//     time    0 ----- window ----- window ----- ...                  from window to window:
//             blocks  |------->|                                     each pair of blocks has a time
//               blocks    |----------->| dismissed                   up to which it is free; its children
//                 triangles   |-->|->||  about to touch: the end     go on from there
//
// Conservative advancement [mirtich-1996] of pairs of blocks, as in [zhang-2006] and [tang-2009], each along the direction in which it
// stays apart longest. Pairs that slide along each other are dismissed, however near they are.
#pragma once

#include "base/fixed_stack.h"
#include "base/progress.h"
#include "query/contacts/motion_bounds.h"

#include <cstdint>
#include <optional>

namespace proxima {

/// How a search for the first contact ended.
enum class SearchEnd : std::uint8_t {
    free,      ///< no contact up to time 1
    meets,     ///< two triangles meet at `meets_at`, exactly
    rounding,  ///< two triangles are nearer than roundings
    steps,     ///< all steps are used up
    cancelled, ///< by the progress
};

struct FirstContact {
    SearchEnd end = SearchEnd::free;
    double free_until = 1; ///< of all pairs
    double meets_at = 0;
    std::uint32_t row_a = 0; ///< of the pair that is about to touch, where there is one
    std::uint32_t row_b = 0;
    Vec3 normal = Vec3::Zero(); ///< that kept this pair apart, of length 1
    std::uint32_t steps = 0;    ///< pairs of blocks that were opened, and steps of triangles
};

/// How long a pair is sure to stay apart, and the direction that shows it.
struct BestStep {
    double step = 0;
    Vec3 direction = Vec3::Zero();
};

/// Noexcept, no allocation, no lock; the same on every instruction set.
class PROXIMA_HIDDEN FirstContactSearch {
public:
    /// What it is given must outlive it. \pre the indexes are not empty
    FirstContactSearch(const IndexParts& a, const IndexParts& b, const RigidMotion& motion,
                       const TimeOfContactOptions& options) noexcept;

    [[nodiscard]] FirstContact find() noexcept;
    [[nodiscard]] const MotionBounds& bounds() const noexcept { return bounds_; }
    /// That of the options, from 0 to 1.
    [[nodiscard]] double tolerance() const noexcept { return tolerance_; }

private:
    /// Blocks that are free of each other up to a time.
    struct PendingBlocks {
        double time;
        std::uint32_t reference_a;
        std::uint32_t reference_b;
        BlockBox box_a;
        BlockBox box_b;
        Vec3 direction;      ///< the best of the last step
        std::uint64_t share; ///< of the progress
    };

    /// Returns up to when all are free, or when the first pair is about to touch. Before `end`, and with
    /// `found_.end` free, where it took too many steps.
    double search_window(double start, double end) noexcept;
    /// Returns up to when all that is pending is free.
    double give_up(const PendingBlocks& at, double start, double end) noexcept;
    void open(const PendingBlocks& at) noexcept;
    void look_at_leaves(const PendingBlocks& at) noexcept;
    void advance(std::uint32_t row_a, std::uint32_t row_b, const MovedFrame& start) noexcept;
    [[nodiscard]] BestStep step_of(const MovedTriangles& pair, const MovedFrame& frame,
                                   const Vec3& hint) const noexcept;
    /// Whether what is free up to a time is of no interest; then it counts for the answer.
    [[nodiscard]] bool is_enough(double time) noexcept;
    [[nodiscard]] bool is_out_of_steps() noexcept;
    void dismiss(std::uint64_t share) noexcept;

    const IndexParts& a_;
    const IndexParts& b_;
    const RigidMotion& motion_;
    MotionBounds bounds_;
    double tolerance_;
    std::uint32_t max_steps_;
    Progress* progress_;
    StageSteps stage_;
    FirstContact found_;
    double limit_ = 1;  ///< the end of the window, or when the first pair found is about to touch
    double enough_ = 1; ///< this, or so little earlier that it makes no difference
    std::uint32_t give_up_at_ = 0; ///< steps
    std::uint64_t ahead_ = 0;      ///< of the progress, counted in a window that was given up
    double current_ = 0;           ///< what is being looked at is free up to this
    Vec3 recent_ = Vec3::Zero();   ///< along which triangles were apart last
    bool is_stopped_ = false;
    // Opening a block replaces a pair by eight at most, and each of two meshes has max_levels of them.
    FixedStack<PendingBlocks, std::size_t{14} * IndexParts::max_levels + 1> pending_;
};

} // namespace proxima
