// The pose of a rigid tool that follows a device's pose and enters nothing.
//
//     wanted     the twist from the proxy to the device
//     list       pairs of triangles within a margin of each other: no other pair can meet before the
//                tool has moved that far
//     contacts   of the pairs that the motion would bring too near
//     motion     the nearest to the wanted one that keeps all contacts apart (least_constraint.h),
//                with friction at the contacts (tool_friction.h)
//     advance    as far as it was proven to pass nothing (triangle_separation.h)
//
// A tick repeats this until the proxy has come as near to the device as it can, or its moves are used
// up: then the next tick goes on. The surfaces keep `clearance` apart, and half of it at the least.
//
// A tick begins with the tool carried along by the object that presses it the most. Other objects move in
// its first move (seen_object.h): constraints and proof are of the tool's motion as each object sees it.
#pragma once

#include "haptics/tool/least_constraint.h"
#include "haptics/tool/rigid_motion.h"
#include "haptics/tool/seen_object.h"
#include "haptics/tool/tool_contacts.h"
#include "haptics/tool/tool_friction.h"
#include "haptics/tool/triangle_separation.h"
#include "proxima/geometry.h"
#include "proxima/tool_renderer.h"
#include "query/distance/near_rows.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace proxima {

struct ToolProxyOptions {
    double clearance = 1e-5;   ///< in the model's unit
    double turning_length = 1; ///< rotation vectors times this weigh as much as displacements
    std::size_t max_moves = 4; ///< in a tick
    std::size_t max_lists = 2; ///< lists of near pairs in a tick
    std::size_t max_work = unlimited_work; ///< in a tick (ToolEffort)
};

/// A contact that holds the tool back.
struct HeldContact {
    FeatureContact contact;
    std::uint32_t object = 0;
    TriangleId scene_triangle{};
    TriangleId tool_triangle{};
    double pressure = 0; ///< part of the stretch along the normal, in the model's unit
};

/// Work of a tick.
struct ToolWork {
    std::size_t moves = 0;
    std::size_t lists = 0;
    std::size_t pairs = 0;    ///< in the last list
    std::size_t contacts = 0; ///< most constraints of a move
    std::size_t spent = 0;    ///< about a microsecond a unit
};

/// One thread. noexcept and without allocation but for the constructor.
class ToolProxy {
public:
    ToolProxy(RigidBody tool, std::vector<SeenObject> objects, const ToolProxyOptions& options);

    /// Says where an object is from the next tick on, and its friction.
    void set_object(std::size_t object, const RigidTransform& pose,
                    const Friction& friction) noexcept;

    /// Whether the tool there would meet no object, nor be inside a closed one or around one.
    [[nodiscard]] bool is_free(const RigidTransform& pose) const noexcept;

    /// Puts the tool there. Returns false, and leaves the proxy where it was, where it is within half
    /// the clearance of an object or inside a closed one, or an object inside a closed tool.
    [[nodiscard]] bool place(const RigidTransform& pose) noexcept;

    /// Follows the device. \pre it was placed
    void follow(const RigidTransform& device) noexcept;

    [[nodiscard]] const RigidTransform& pose() const noexcept { return pose_; }
    [[nodiscard]] ToolEnd end() const noexcept { return end_; }
    /// Whether an object is behind that did not come on in the last tick, for all its work.
    [[nodiscard]] bool is_held_up() const noexcept
    {
        return end_ == ToolEnd::limited && is_behind() && last_way_ < options_.clearance;
    }
    [[nodiscard]] Hold hold() const noexcept;
    [[nodiscard]] const ToolWork& work() const noexcept { return work_; }
    [[nodiscard]] std::span<const HeldContact> contacts() const noexcept
    {
        return std::span(held_).first(held_count_);
    }
    [[nodiscard]] std::span<const SeenObject> objects() const noexcept { return objects_; }

    /// Poses of the last tick, with twists between them that pass nothing.
    [[nodiscard]] std::span<const RigidTransform> path() const noexcept
    {
        return std::span(path_).first(path_count_);
    }

    /// Where the tool saw an object at each pose of the path. In the object's frame the tool makes
    /// the twists between its relative poses.
    [[nodiscard]] std::span<const RigidTransform> object_path(std::size_t object) const noexcept
    {
        return std::span(object_paths_).subspan(object * path_size, path_count_);
    }

    static constexpr std::size_t most_moves = 32;

private:
    /// Where a tick begins, where an object carried the tool to, and its moves.
    static constexpr std::size_t path_size = most_moves + 2;

    enum class OpenPairs : std::uint8_t { all, unconstrained };
    enum class MoveEnd : std::uint8_t { settled, goes_on, overloaded };

    /// A motion of the tool and of the objects that move.
    struct Move {
        Twist twist;       ///< of the tool
        RigidTransform to; ///< its pose at the end
        double way = 0;    ///< of its points, at most, in the world or as an object sees them
        double seen = 0;   ///< the same as objects see them: 0 where they carry the tool along
    };

    [[nodiscard]] bool has_friction() const noexcept;
    [[nodiscard]] bool list_pairs(double margin) noexcept;
    [[nodiscard]] bool list_pairs_once(double margin) noexcept;
    [[nodiscard]] double room(const SeenObject& object) const noexcept;
    [[nodiscard]] double room() const noexcept;
    [[nodiscard]] double listed_part() const noexcept;
    [[nodiscard]] bool is_behind() const noexcept;
    [[nodiscard]] double way_of_objects() const noexcept;
    void step_objects(double part) noexcept;
    [[nodiscard]] Move make_move(const Twist& twist, double part) noexcept;
    void make(const Move& whole, double share, const RigidTransform& to, double part) noexcept;
    [[nodiscard]] const SeenObject* carrier() const noexcept;
    void carry() noexcept;
    [[nodiscard]] double make_proven(const Move& motion, double part) noexcept;
    void keep_path() noexcept;
    [[nodiscard]] bool add_contacts(std::uint32_t pair, double nearest, double farthest) noexcept;
    void collect_near() noexcept;
    [[nodiscard]] std::span<NearPair*> open_pairs(const SeenObject& object, double least,
                                                  OpenPairs which) noexcept;
    [[nodiscard]] bool collect_hit(const Move& motion) noexcept;
    void solve_constraints(const Vec6& wanted) noexcept;
    [[nodiscard]] bool raise_bounds() noexcept;
    [[nodiscard]] Twist solve(const Vec6& wanted) noexcept;
    [[nodiscard]] double proven_part(const SeenObject* carrier = nullptr) noexcept;
    [[nodiscard]] MoveEnd move(const Twist& wanted) noexcept;
    [[nodiscard]] ToolEnd approach() noexcept;
    [[nodiscard]] double cost(const RigidTransform& pose, const Vec6& wanted,
                              double steepness) const noexcept;
    [[nodiscard]] double useful_part(const Move& motion, const Vec6& wanted) const noexcept;
    void hold_back(const ConstrainedMotion& motion) noexcept;

    RigidBody tool_;
    std::vector<SeenObject> objects_;
    ToolProxyOptions options_;
    double base_margin_;
    RigidTransform pose_;
    RigidTransform device_;
    double list_margin_ = -1;   ///< none yet
    bool objects_move_ = false; ///< in this move
    double most_margin_;        ///< of the next list, so that it is short
    std::vector<NearRows> rows_;
    std::vector<NearPair> pairs_;
    std::size_t pair_count_ = 0;
    std::size_t near_count_ = 0;  ///< pairs that were near in the last move
    std::size_t plain_count_ = 0; ///< of a move: pairs that only a vertex of one triangle can touch
    double travelled_ = 0;        ///< by points of the tool since the last list, at most, as seen
    std::vector<double> apart_until_; ///< by pair: its triangles meet no sooner than that much
                                      ///< was travelled
    std::vector<NearPair*> open_;     ///< pairs that no known plane keeps apart
    std::vector<FeatureContact> contacts_;
    std::size_t contact_count_ = 0;
    std::vector<MotionConstraint> constraints_;
    ToolFriction friction_;
    std::array<HeldContact, 6> held_;
    std::size_t held_count_ = 0;
    std::array<RigidTransform, path_size> path_;
    std::vector<RigidTransform> object_paths_; ///< by object, path_size each
    std::size_t path_count_ = 0;
    ConstrainedMotion solution_;
    double last_way_ = 0;  ///< of the last tick's path
    double last_seen_ = 0; ///< the same as objects saw it
    ToolEnd end_ = ToolEnd::settled;
    ToolWork work_;
    ToolEffort effort_;
};

} // namespace proxima
