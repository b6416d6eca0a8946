#include "query/contacts/first_contact.h"

#include "geometry/closest_point.h"
#include "geometry/exact_predicates.h"
#include "geometry/length.h"
#include "geometry/triangle_contact.h"
#include "geometry/triangle_distance.h"
#include "query/contacts/child_steps.h"
#include "query/contacts/leaf_pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace proxima {

namespace {

constexpr std::uint64_t whole_share = std::uint64_t{1} << 30U; // of the progress
constexpr double rounded_down = 1 - 0x1p-40;                   // of steps

std::uint64_t share_until(double time)
{
    return static_cast<std::uint64_t>(std::clamp(time, 0.0, 1.0) * whole_share);
}

} // namespace

FirstContactSearch::FirstContactSearch(const IndexParts& a, const IndexParts& b,
                                       const RigidMotion& motion,
                                       const TimeOfContactOptions& options) noexcept
    : a_(a), b_(b), motion_(motion), bounds_(a, b, motion),
      tolerance_(options.tolerance > 0 ? std::min(options.tolerance, 1.0) : 0),
      max_steps_(options.max_steps), progress_(options.execution.progress),
      stage_(progress_, "finding the time of contact", whole_share, whole_share / 1024)
{}

FirstContact FirstContactSearch::find() noexcept
{
    if (bounds_.is_at_rest()) return found_;
    // Long motions in pieces: blocks that come near each other are not taken apart for good. Pieces of an
    // eighth of the smaller mesh at first, then twice or half as long, whichever takes fewer steps for its
    // time: where little is near, their number grows only with the logarithm of the way.
    constexpr double sizes = 0.125;
    constexpr double shortest = 0x1p-40;
    const double least = std::clamp(sizes * bounds_.size() / bounds_.fastest(), shortest, 1.0);
    constexpr double widest = 0.25; // radians: what turns farther is bounded badly
    const double angle = length_of(motion_.turn);
    const double most = angle > widest ? std::max(least, widest / angle) : 1.0;
    double window = least;
    double factor = 2;
    double steps_a_time = HUGE_VAL;
    std::uint32_t last_steps = 0;
    int in_a_row = 0; // pieces in which blocks were opened
    double time = 0;
    while (time < 1 && found_.end == SearchEnd::free) {
        const std::uint32_t before = found_.steps;
        const double end = std::min(1.0, time + window);
        give_up_at_ = window == least ? UINT32_MAX : before + 128 + 2 * last_steps;
        const double free_until = search_window(time, end);
        last_steps = found_.steps - before;
        ++in_a_row;
        if (free_until > end) { // far from everything: as good as it gets
            window = std::max(least, window / 2);
            in_a_row = 0;
        } else if (free_until < end) { // given up
            window = std::max(least, window / 4);
            steps_a_time = HUGE_VAL;
        } else if (in_a_row > 4) {
            const double now = last_steps / (end - time);
            if (window == least) {
                factor = 2;
            } else if (now > steps_a_time) {
                factor = 1 / factor;
            }
            steps_a_time = now;
            window = std::clamp(factor * window, least, most);
        }
        time = free_until;
    }
    return found_;
}

double FirstContactSearch::search_window(double start, double end) noexcept
{
    current_ = start;
    if (is_out_of_steps()) return start;
    constexpr BlockBox root = {{0, 0, 0}, {1.01F, 1.01F, 1.01F}};
    const MovedFrame frame = bounds_.frame_at(start);
    const BoundedBlock whole_a = bounds_.block_of_a(root, a_.root());
    const BoundedBlock whole_b = bounds_.block_of_b(root, b_.root(), frame);
    ChildSteps first;
    find_child_steps(bounds_,
                     {.frame = frame,
                      .a = whole_a,
                      .b = whole_b,
                      .node = nullptr,
                      .opens_a = false,
                      .hint = recent_,
                      .within = 1 - start,
                      .enough = 1 - start},
                     first);
    ++found_.steps;
    const double free_until = start + first.step[0] * rounded_down;
    if (free_until >= end) {
        dismiss(share_until(free_until) - share_until(start));
        return free_until;
    }
    limit_ = end;
    enough_ = end;
    pending_.push({free_until, a_.root(), b_.root(), root, root, first.direction_of(0),
                   share_until(end) - share_until(start)});
    while (!pending_.empty()) {
        const PendingBlocks at = pending_.pop();
        if (is_enough(at.time)) {
            dismiss(at.share);
            continue;
        }
        current_ = at.time;
        if (is_out_of_steps()) return limit_;
        if (found_.steps >= give_up_at_ && found_.end == SearchEnd::free)
            return give_up(at, start, end);
        ++found_.steps;
        const bool both_leaves = (at.reference_a & at.reference_b & index_leaf_bit) != 0;
        both_leaves ? look_at_leaves(at) : open(at);
    }
    return limit_;
}

double FirstContactSearch::give_up(const PendingBlocks& at, double start, double end) noexcept
{
    double free_until = at.time;
    std::uint64_t left = at.share;
    while (!pending_.empty()) {
        const PendingBlocks other = pending_.pop();
        free_until = std::min(free_until, other.time);
        left += other.share;
    }
    const std::uint64_t done = share_until(end) - share_until(start) - left;
    ahead_ += done - std::min(done, share_until(free_until) - share_until(start));
    return free_until;
}

void FirstContactSearch::open(const PendingBlocks& at) noexcept
{
    const auto largest = [](const BlockBox& box, double unit) {
        return unit * double{std::max({box.half[0], box.half[1], box.half[2]})};
    };
    const bool opens_a =
        (at.reference_b & index_leaf_bit) != 0 ||
        ((at.reference_a & index_leaf_bit) == 0 &&
         largest(at.box_a, bounds_.unit_a()) >= largest(at.box_b, bounds_.unit_b()));
    const IndexNode& node =
        opens_a ? a_.blocks()[at.reference_a].node : b_.blocks()[at.reference_b].node;
    const MovedFrame frame = bounds_.frame_at(at.time);
    const BoundedBlock a = bounds_.block_of_a(at.box_a, at.reference_a);
    const BoundedBlock b = bounds_.block_of_b(at.box_b, at.reference_b, frame);
    ChildSteps steps;
    find_child_steps(bounds_,
                     {.frame = frame,
                      .a = a,
                      .b = b,
                      .node = &node,
                      .opens_a = opens_a,
                      .hint = at.direction,
                      .within = limit_ - at.time,
                      .enough = enough_ - at.time},
                     steps);
    std::array<std::uint8_t, 8> order; // the latest first
    std::size_t count = 0;
    for (std::uint8_t slot = 0; slot < 8; ++slot) {
        if (steps.step[slot] < 0) continue;
        steps.step[slot] = at.time + steps.step[slot] * rounded_down;
        if (is_enough(steps.step[slot])) continue;
        const auto key = [&](std::uint8_t s) { return std::pair(steps.step[s], steps.apart[s]); };
        std::size_t position = count++;
        for (; position > 0 && key(order[position - 1]) < key(slot); --position)
            order[position] = order[position - 1];
        order[position] = slot;
    }
    std::uint64_t left = at.share;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t slot = order[i];
        PendingBlocks next = at;
        next.time = steps.step[slot];
        (opens_a ? next.reference_a : next.reference_b) = node.children[slot];
        (opens_a ? next.box_a : next.box_b) = steps.box[slot];
        next.direction = steps.direction_of(slot);
        next.share = left / (count - i);
        left -= next.share;
        pending_.push(next);
    }
    dismiss(left);
}

void FirstContactSearch::look_at_leaves(const PendingBlocks& at) noexcept
{
    const IndexLeaf& leaf_a = a_.blocks()[at.reference_a & ~index_leaf_bit].leaf;
    const IndexLeaf& leaf_b = b_.blocks()[at.reference_b & ~index_leaf_bit].leaf;
    const MovedFrame frame = bounds_.frame_at(at.time);
    LeafPairs pairs(bounds_, leaf_a, leaf_b, frame);
    const auto filter = [&](const Vec3& direction) {
        (void)pairs.filter(direction, limit_ - at.time);
        if (enough_ < limit_ && pairs.filter(direction, enough_ - at.time))
            found_.free_until = std::min(found_.free_until, enough_);
    };
    filter(at.direction);
    filter(recent_);
    while (!pairs.empty() && !is_out_of_steps()) {
        const auto rows = pairs.pop();
        advance(rows.a, rows.b, frame);
        if (is_enough(at.time)) break;
        // What keeps a pair apart will often do for its neighbours.
        filter(recent_);
    }
    dismiss(at.share);
}

BestStep FirstContactSearch::step_of(const MovedTriangles& pair, const MovedFrame& frame,
                                     const Vec3& hint) const noexcept
{
    const double enough = enough_ - frame.time;
    if (!hint.isZero(0)) {
        const double step = bounds_.step(bounds_.along(hint), pair);
        if (step >= enough) return {step, hint};
    }
    BestStep best;
    const auto try_along = [&](const Vec3& direction, const Vec3& towards) {
        if (direction.isZero(0) || best.step >= enough) return;
        const Vec3 there = direction.dot(towards) < 0 ? Vec3(-direction) : direction;
        const double step = bounds_.step(bounds_.along(there), pair);
        if (step > best.step) best = {step, there};
    };
    const auto side = [](const Triangle& t, int i) { return Vec3(t[(i + 1) % 3] - t[i]); };
    // Most pairs are dismissed by a plane through one of the triangles, which takes least to try.
    for (const Triangle* const t : {&pair.a, &pair.b}) {
        const Vec3 normal = side(*t, 0).cross(side(*t, 1));
        const double length = normal.norm();
        constexpr double safe = 1e-100; // squares have not vanished
        if (length > safe) try_along(normal / length, pair.b[0] - pair.a[0]);
    }
    if (best.step >= enough) return best;
    const ClosestTrianglePoints closest = closest_points(pair.a, pair.b);
    const Vec3 across = closest.second.point - closest.first.point;
    const auto consider = [&](const Vec3& u, const Vec3& v) {
        if (best.step < enough)
            try_along(unit_normal({Vec3::Zero(), u}, {Vec3::Zero(), v}), across);
    };
    try_along(unit_of(across), across);
    // Points that are all but one say little about the direction; the triangles say it.
    consider(side(pair.a, 0), side(pair.a, 1));
    consider(side(pair.b, 0), side(pair.b, 1));
    const auto number = [](TrianglePart part) {
        return part >= TrianglePart::side_0 && part <= TrianglePart::side_2
                   ? static_cast<int>(part) - static_cast<int>(TrianglePart::side_0)
                   : -1;
    };
    const int on_a = number(closest.first.part);
    const int on_b = number(closest.second.part);
    if (on_a >= 0 && on_b >= 0) consider(side(pair.a, on_a), side(pair.b, on_b));
    if (best.step == 0) best.direction = unit_of(across);
    return best;
}

void FirstContactSearch::advance(std::uint32_t row_a, std::uint32_t row_b,
                                 const MovedFrame& start) noexcept
{
    Vec3 hint = Vec3::Zero();
    for (MovedFrame frame = start; !is_out_of_steps();) {
        const BestStep best = step_of(bounds_.triangles(row_a, row_b, frame), frame, hint);
        hint = best.direction;
        ++found_.steps;
        const double next = frame.time + best.step * rounded_down;
        if (is_enough(next)) {
            recent_ = best.direction;
            return;
        }
        const bool is_stuck = next == frame.time;
        if (best.step < 0.5 * tolerance_ || is_stuck) {
            const double later = std::nextafter(frame.time, 2.0);
            const double probe = std::min(1.0, std::max(frame.time + 0.5 * tolerance_, later));
            const bool meets =
                triangles_meet(a_.triangle(row_a), pose_at(motion_, probe)(b_.triangle(row_b)));
            if (meets || is_stuck) {
                limit_ = frame.time;
                // Where a contact is shown, the answer may be half the tolerance early. Where it is
                // not, later probes begin here, and roundings must be all that hides it.
                const double earlier = meets ? 0.5 * tolerance_ : 0.0;
                enough_ = limit_ - std::max(earlier, bounds_.rounding());
                found_.free_until = std::min(found_.free_until, limit_);
                found_.end = meets ? SearchEnd::meets : SearchEnd::rounding;
                found_.meets_at = probe;
                found_.row_a = row_a;
                found_.row_b = row_b;
                found_.normal = best.direction;
                return;
            }
        }
        frame = bounds_.frame_at(next);
    }
}

bool FirstContactSearch::is_enough(double time) noexcept
{
    if (time < enough_) return false;
    if (found_.end != SearchEnd::free) found_.free_until = std::min(found_.free_until, time);
    return true;
}

bool FirstContactSearch::is_out_of_steps() noexcept
{
    if (is_stopped_) return true;
    const bool is_asked = is_cancelled(progress_);
    if (!is_asked && found_.steps < max_steps_) return false;
    is_stopped_ = true;
    found_.end = is_asked ? SearchEnd::cancelled : SearchEnd::steps;
    double free_until = std::min(found_.free_until, current_);
    while (!pending_.empty()) free_until = std::min(free_until, pending_.pop().time);
    found_.free_until = free_until;
    return true;
}

void FirstContactSearch::dismiss(std::uint64_t share) noexcept
{
    const std::uint64_t known = std::min(share, ahead_);
    ahead_ -= known;
    if (progress_ != nullptr) (void)stage_.done(share - known);
}

} // namespace proxima
