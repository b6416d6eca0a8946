#include "haptics/tool/tool_proxy.h"

#include "index/index_parts.h"

#include <algorithm>
#include <utility>

namespace proxima {

namespace {

constexpr std::size_t max_pairs = 2048;
constexpr std::size_t max_contacts = 1024;
constexpr int max_rounds = 6;
/// Times that a move with objects is tried, each time shorter; then nothing moves.
constexpr int max_shorter = 4;
/// The part of a tick's work within which moves begin. What is left is for contacts and the proof.
constexpr double begin_share = 0.5;
/// Lists reach at least so many clearances farther than the tool is going to move.
constexpr double margin_clearances = 10;
/// A motion that is shorter than so many clearances settles the proxy.
constexpr double settled_clearances = 0.1;
/// So does one that shortens the stretch of the springs by less than so many.
constexpr double gain_clearances = 0.02;
/// The part of a motion that is made at least.
constexpr double least_part = 0.05;
constexpr double constraint_tolerance = 1e-4; ///< clearances
/// Solutions of a motion that make up for the arcs of its contacts, and what they need not make up for.
constexpr int max_arc_rounds = 2;
constexpr double arc_tolerance = 0.1; ///< clearances
/// Objects move alike that see the tool move by less, where one of them carries it.
constexpr double carried_clearances = 1e-3;
/// A contact slides that slips by more than so many clearances in a motion.
constexpr double least_slip = 1e-3;
/// Contacts that the solver with friction takes in a unit of work, in each of its steps.
constexpr std::size_t friction_contacts_per_work = 32;

} // namespace

ToolProxy::ToolProxy(RigidBody tool, std::vector<SeenObject> objects,
                     const ToolProxyOptions& options)
    : tool_(std::move(tool)), objects_(std::move(objects)), options_(options),
      base_margin_(margin_clearances * options.clearance), most_margin_(base_margin_),
      friction_(
          {.turning_length = options.turning_length, .least_slip = least_slip * options.clearance},
          max_contacts)
{
    options_.max_moves = std::min(options_.max_moves, most_moves);
    rows_.resize(max_pairs);
    pairs_.resize(max_pairs);
    apart_until_.resize(max_pairs);
    open_.resize(max_pairs);
    contacts_.resize(max_contacts);
    constraints_.resize(max_contacts);
    object_paths_.resize(objects_.size() * path_size);
}

void ToolProxy::set_object(std::size_t object, const RigidTransform& pose,
                           const Friction& friction) noexcept
{
    objects_[object].goal = pose;
    objects_[object].friction = friction;
}

bool ToolProxy::is_free(const RigidTransform& pose) const noexcept
{
    return std::ranges::none_of(objects_, [&](const SeenObject& object) {
        const RigidTransform relative = object.seen_from_goal(pose);
        if (meshes_intersect(object.body.index, tool_.index, relative)) return true;
        const ContainmentAnswer answer =
            find_containment(object.body.inside, tool_.inside, relative);
        // Open meshes have no inside.
        return answer.containment != Containment::none &&
               answer.method != InsideMethod::winding_number;
    });
}

bool ToolProxy::place(const RigidTransform& pose) noexcept
{
    friction_.restart();
    held_count_ = 0;
    path_count_ = 0;
    last_seen_ = 0;
    work_ = {};
    end_ = ToolEnd::settled;
    list_margin_ = -1;
    most_margin_ = base_margin_;
    near_count_ = 0;
    if (!is_free(pose)) return false;
    for (SeenObject& object : objects_) {
        object.pose = object.goal;
        object.look_at(pose);
    }
    const RigidTransform before = std::exchange(pose_, pose);
    bool is_free = list_pairs(base_margin_);
    if (is_free) {
        const double least = 0.5 * options_.clearance;
        for (const SeenObject& object : objects_) {
            std::size_t open = 0;
            for (std::uint32_t i = object.first_pair; i < object.end_pair; ++i)
                if (!(plane_gap(pairs_[i], object.relative) >= least)) open_[open++] = &pairs_[i];
            const auto too_near = std::span(open_).first(open);
            set_closest_planes(too_near, object.relative);
            is_free = is_free && std::ranges::all_of(too_near, [&](const NearPair* pair) {
                          return plane_gap(*pair, object.relative) >= least;
                      });
        }
    }
    if (!is_free) {
        pose_ = before;
        list_margin_ = -1;
        most_margin_ = base_margin_;
    }
    return is_free;
}

bool ToolProxy::is_behind() const noexcept
{
    return std::ranges::any_of(objects_, [](const SeenObject& each) { return each.is_behind(); });
}

/// How far objects that are behind have to move at most, as points of the tool see it.
double ToolProxy::way_of_objects() const noexcept
{
    double longest = 0;
    for (const SeenObject& object : objects_) {
        if (!object.is_behind()) continue;
        const double reach = (pose_.translation - object.pose.translation).norm();
        longest = std::max(
            longest,
            twist_between(object.pose, object.goal).path_length(reach + tool_.features.reach()));
    }
    return longest;
}

/// Objects that are behind step by a part of what is left, in the next move.
void ToolProxy::step_objects(double part) noexcept
{
    objects_move_ = false;
    for (SeenObject& object : objects_) {
        object.begin_step(part);
        objects_move_ = objects_move_ || object.moves;
    }
}

/// A part of a twist with that part of the objects' steps, as all objects see it.
ToolProxy::Move ToolProxy::make_move(const Twist& twist, double part) noexcept
{
    const double reach = tool_.features.reach();
    Move result = {part < 1 ? twist.scaled(part) : twist, moved_by(pose_, twist, part)};
    result.way = result.twist.path_length(reach);
    for (SeenObject& object : objects_) {
        object.set_motion(twist, result.to, part);
        const double seen = object.moves ? object.motion.twist.path_length(reach) : result.way;
        result.seen = std::max(result.seen, seen);
    }
    result.way = std::max(result.way, result.seen);
    return result;
}

void ToolProxy::keep_path() noexcept
{
    for (std::size_t i = 0; i < objects_.size(); ++i)
        object_paths_[i * path_size + path_count_] = objects_[i].pose;
    path_[path_count_++] = pose_;
}

Hold ToolProxy::hold() const noexcept
{
    if (held_count_ == 0) return Hold::free;
    return has_friction() ? friction_.hold() : Hold::sliding;
}

bool ToolProxy::has_friction() const noexcept
{
    return std::ranges::any_of(objects_,
                               [](const SeenObject& each) { return each.friction.fixed > 0; });
}

void ToolProxy::solve_constraints(const Vec6& wanted) noexcept
{
    const auto constraints = std::span<const MotionConstraint>(constraints_).first(contact_count_);
    const double tolerance = constraint_tolerance * options_.clearance;
    if (!has_friction()) {
        solution_ = least_constraint(wanted, constraints, tolerance);
        return;
    }
    solution_ = friction_.solve(wanted, pose_, objects_, std::span(contacts_).first(contact_count_),
                                constraints, tolerance);
    effort_.spent += friction_.steps() * (1 + contact_count_ / friction_contacts_per_work);
}

/// Contacts that move on arcs come nearer than a straight motion takes them: raises their bounds by what
/// the gap lacks after the solution's motion, an object's own turn left out. Returns false where it lacks
/// nothing.
bool ToolProxy::raise_bounds() noexcept
{
    const Twist twist = {solution_.motion.head<3>(),
                         solution_.motion.tail<3>() / options_.turning_length};
    const RigidTransform to = moved_by(pose_, twist, 1);
    const Mat3 turn = to.rotation * pose_.rotation.transpose();
    bool lacks = false;
    for (std::size_t i = 0; i < contact_count_; ++i) {
        const FeatureContact& contact = contacts_[i];
        const SeenObject& object = objects_[contact.object];
        Vec3 point = turn * (contact.tool_point - pose_.translation) + to.translation;
        if (object.moves) point -= object.displacement(contact.scene_point);
        const double lack = options_.clearance - contact.gap_after(turn, point);
        if (!(lack > arc_tolerance * options_.clearance)) continue;
        constraints_[i].bound += lack;
        lacks = true;
    }
    return lacks;
}

/// The motion nearest to the wanted one that all contacts and their friction allow.
Twist ToolProxy::solve(const Vec6& wanted) noexcept
{
    const double length = options_.turning_length;
    work_.contacts = std::max(work_.contacts, contact_count_);
    const auto constraints = std::span(constraints_).first(contact_count_);
    for (std::size_t i = 0; i < contact_count_; ++i) {
        const FeatureContact& contact = contacts_[i];
        const Vec3 arm = contact.tool_point - pose_.translation;
        constraints[i].direction.head<3>() = contact.normal;
        constraints[i].direction.tail<3>() = arm.cross(contact.normal) / length;
        constraints[i].bound = options_.clearance - contact.gap;
        const SeenObject& object = objects_[contact.object];
        if (object.moves)
            constraints[i].bound += contact.normal.dot(object.displacement(contact.scene_point));
    }
    solve_constraints(wanted);
    for (int round = 0; round < max_arc_rounds && solution_.solved && raise_bounds(); ++round) {
        const ConstrainedMotion straight = solution_;
        solve_constraints(wanted);
        if (solution_.solved) continue;
        solution_ = straight;
        break;
    }
    if (!solution_.solved) {
        // There may be no room for the whole clearance: then no contact may come nearer.
        for (MotionConstraint& each : constraints) each.bound = std::min(each.bound, 0.0);
        solve_constraints(wanted);
    }
    if (!solution_.solved) {
        solution_ = {};
        solution_.solved = false;
    }
    return {solution_.motion.head<3>(), solution_.motion.tail<3>() / length};
}

/// What the proxy's pose costs: the springs' energy, what friction takes on the way, and what it takes to
/// restore the clearance at the contacts, twice as steep as they press (an exact penalty).
double ToolProxy::cost(const RigidTransform& pose, const Vec6& wanted,
                       double steepness) const noexcept
{
    double short_of = 0;
    const Mat3 turn = pose.rotation * pose_.rotation.transpose();
    for (const FeatureContact& contact : std::span(contacts_).first(contact_count_)) {
        const Vec3 point = turn * (contact.tool_point - pose_.translation) + pose.translation;
        short_of += std::max(options_.clearance - contact.gap_after(turn, point), 0.0);
    }
    const double lost = has_friction() ? friction_.loss(pose) : 0;
    return 0.5 * wanted.squaredNorm() + steepness * short_of + lost;
}

/// The part of the motion that lowers the cost the most: all of it but where the tool's arcs leave
/// the contacts' planes by more than the motion gains. By the parabola through the cost at both ends
/// with the slope at the beginning.
double ToolProxy::useful_part(const Move& motion, const Vec6& wanted) const noexcept
{
    // Objects do not wait.
    if (contact_count_ == 0 || objects_move_) return 1;
    double steepness = 0;
    for (std::size_t k = 0; k < solution_.active_count; ++k)
        steepness = std::max(steepness, 2 * solution_.pressure[k]);
    const double length = options_.turning_length;
    Vec6 step;
    step.head<3>() = motion.twist.linear;
    step.tail<3>() = length * motion.twist.angular;
    const Twist left = twist_between(motion.to, device_);
    Vec6 after;
    after.head<3>() = left.linear;
    after.tail<3>() = length * left.angular;
    const double begin = cost(pose_, wanted, steepness);
    const double end = cost(motion.to, after, steepness);
    const double lost = has_friction() ? friction_.loss(step) : 0;
    const double slope = lost - wanted.dot(step) - (begin - 0.5 * wanted.squaredNorm());
    const double bend = end - begin - slope;
    if (!(slope < 0) || !(bend > 0)) return 1;
    return std::clamp(-0.5 * slope / bend, least_part, 1.0);
}

/// Takes tool and objects to where they are after that part of a move, of whose ways a share is made.
void ToolProxy::make(const Move& whole, double share, const RigidTransform& to,
                     double part) noexcept
{
    pose_ = to;
    for (SeenObject& object : objects_) {
        object.pose = object.stepped(part);
        object.look_at(pose_);
    }
    last_way_ += share * whole.way;
    last_seen_ += share * whole.seen;
    travelled_ += share * whole.seen;
    keep_path();
}

/// The object that presses the tool the most, or the only one; null where neither is behind.
const SeenObject* ToolProxy::carrier() const noexcept
{
    const SeenObject* found = objects_.size() == 1 ? objects_.data() : nullptr;
    double most = 0;
    for (const HeldContact& held : contacts()) {
        if (!(held.pressure > most)) continue;
        most = held.pressure;
        found = &objects_[held.object];
    }
    return found != nullptr && found->is_behind() ? found : nullptr;
}

/// Takes the tool along with the object that holds it, which sees no motion then: what is left of the
/// tick is as if it were at rest. Where something may be in the way, nothing moves.
void ToolProxy::carry() noexcept
{
    const SeenObject* const by = carrier();
    if (by == nullptr || list_margin_ < 0) return;
    const Mat3 turned = by->goal.rotation * by->relative.rotation;
    const RigidTransform carried = {Eigen::Quaterniond(turned).normalized().toRotationMatrix(),
                                    by->goal(by->relative.translation)};
    // With objects that move alike, as all of a train.
    for (SeenObject& object : objects_) {
        const double seen = twist_between(object.relative, object.seen_from_goal(carried))
                                .path_length(tool_.features.reach());
        const bool goes_along = seen < carried_clearances * options_.clearance;
        if (&object == by && !goes_along) return; // the proof below leaves it out
        object.begin_step(goes_along ? 1 : 0);
    }
    Move move = make_move(twist_between(pose_, carried), 1);
    move.to = carried;
    if (listed_part() < 1 || proven_part(by) < 1) return;
    make(move, 1, carried, 1);
}

/// Moves tool and objects by what of that part of the move was proven to pass nothing. Returns the part.
double ToolProxy::make_proven(const Move& motion, double part) noexcept
{
    Move made = part < 1 ? make_move(motion.twist, part) : motion;
    double proven = proven_part();
    if (objects_move_) {
        // A part of a move is not that part of the twists that objects see: it is proven anew.
        for (int shorter = 0; proven < 1 && shorter < max_shorter; ++shorter) {
            part = shorter + 1 < max_shorter ? 0.9 * proven * part : 0;
            made = make_move(motion.twist, part);
            proven = part > 0 ? proven_part() : 1;
        }
    } else if (proven < 1) {
        part *= proven;
        made = make_move(motion.twist, part);
    }
    make(objects_move_ ? made : motion, objects_move_ ? 1 : part, made.to, part);
    return part;
}

void ToolProxy::hold_back(const ConstrainedMotion& motion) noexcept
{
    held_count_ = motion.active_count;
    for (std::size_t k = 0; k < held_count_; ++k) {
        const FeatureContact& contact = contacts_[motion.active[k]];
        const NearPair& pair = pairs_[contact.pair];
        const MeshIndex& index = objects_[pair.object].body.index;
        held_[k] = {contact, pair.object, index.parts().id(pair.scene_row),
                    tool_.index.parts().id(pair.tool_row), motion.pressure[k]};
    }
}

/// One move towards the device.
ToolProxy::MoveEnd ToolProxy::move(const Twist& wanted) noexcept
{
    Vec6 free;
    free.head<3>() = wanted.linear;
    free.tail<3>() = options_.turning_length * wanted.angular;
    double steps = 1; // part of the objects' ways
    step_objects(steps);
    collect_near();
    Move motion = make_move(solve(free), 1);
    for (int round = 0;; ++round) {
        const double part = listed_part();
        if (part < 1) {
            const double margin = base_margin_ + 1.5 * motion.seen;
            if (list_margin_ < std::min(margin, most_margin_) && work_.lists < options_.max_lists) {
                if (!list_pairs(margin)) return MoveEnd::overloaded;
                collect_near();
                motion = make_move(solve(free), 1);
                continue;
            }
            steps *= part;
            if (objects_move_) step_objects(steps);
            motion = make_move(motion.twist.scaled(part), 1);
        }
        if (!collect_hit(motion) || round >= max_rounds || effort_.cut_short) break;
        motion = make_move(solve(free), 1);
    }
    // Friction holds the tool: it rests, and does not creep by what the solver rounds.
    if (has_friction() && solution_.solved && !is_behind() &&
        motion.way < constraint_tolerance * options_.clearance) {
        hold_back(solution_);
        return MoveEnd::settled;
    }
    const double part = make_proven(motion, useful_part(motion, free));
    hold_back(solution_);
    const double settled = settled_clearances * options_.clearance;
    Vec6 left;
    const Twist rest = twist_between(pose_, device_);
    left.head<3>() = rest.linear;
    left.tail<3>() = options_.turning_length * rest.angular;
    const bool gains = std::abs(left.norm() - free.norm()) > gain_clearances * options_.clearance;
    const bool goes_on = !solution_.solved || objects_move_ || is_behind() ||
                         (motion.way > settled && (gains || part < least_part));
    return goes_on ? MoveEnd::goes_on : MoveEnd::settled;
}

void ToolProxy::follow(const RigidTransform& device) noexcept
{
    work_ = {};
    effort_ = {.most = options_.max_work};
    device_ = device;
    path_count_ = 0;
    keep_path();
    end_ = approach();
    if (end_ != ToolEnd::overloaded && effort_.cut_short) end_ = ToolEnd::cut_short;
    work_.spent = effort_.spent;
}

/// Moves towards the device until the proxy settles or the tick ends.
ToolEnd ToolProxy::approach() noexcept
{
    const double expected = 2 * std::exchange(last_seen_, 0.0);
    last_way_ = 0;
    carry();
    const double reach = tool_.features.reach();
    int still = 0; // moves in a row that came no nearer
    while (work_.moves < options_.max_moves && still < 2 && effort_.begin(0, begin_share)) {
        const Twist wanted = twist_between(pose_, device_);
        const double length = wanted.path_length(reach) + way_of_objects();
        if (room() < std::min(length, options_.clearance)) {
            if (work_.lists == options_.max_lists) return ToolEnd::limited;
            if (!list_pairs(base_margin_ + std::min(length, expected))) return ToolEnd::overloaded;
        }
        ++work_.moves;
        const double before = last_way_;
        const MoveEnd end = move(wanted);
        if (end == MoveEnd::overloaded) return ToolEnd::overloaded;
        if (solution_.active_count == 0 && solution_.solved &&
            last_way_ - before >= length * (1 - 1e-12)) {
            pose_ = device_;
            path_[path_count_ - 1] = pose_;
            for (SeenObject& object : objects_) object.look_at(pose_);
            return ToolEnd::settled;
        }
        if (end == MoveEnd::settled) return ToolEnd::settled;
        still = last_way_ - before > settled_clearances * options_.clearance ? 0 : still + 1;
    }
    return ToolEnd::limited;
}

} // namespace proxima
