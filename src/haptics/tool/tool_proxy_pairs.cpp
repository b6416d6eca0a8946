// Pairs of triangles that are near each other: their lists, their contacts, and the proof that a move
// keeps them apart.
#include "haptics/tool/tool_proxy.h"
#include "index/index_parts.h"

#include <algorithm>
#include <limits>

namespace proxima {

namespace {

/// Lists with more pairs that are not near are followed by ones with half the margin, with fewer by ones
/// with twice that. Pairs that are near are in every list.
constexpr std::size_t many_pairs = 800;
constexpr std::size_t few_pairs = 300;
constexpr double least_margin_clearances = 2;
/// The work of a list, and pairs that add a unit to it.
constexpr std::size_t list_work = 100;
constexpr std::size_t listed_pairs_per_work = 8;
/// Pairs whose planes are looked at in a unit of work.
constexpr std::size_t looks_per_work = 32;
constexpr std::size_t contacts_work = 1; ///< of the contacts of a pair
/// Pairs of which one triangle tells of no vertex or edge, as those inside a flat face, in a unit of work.
constexpr std::size_t plain_pairs_per_work = 8;
constexpr std::size_t open_pairs_work = 2; ///< of planes for eight pairs
/// The part of a tick's work within which contacts are found. What is left is for the proof.
constexpr double contacts_share = 0.75;
/// Pairs that are nearer than so many clearances are among the constraints from the start.
constexpr double near_clearances = 2;

} // namespace

/// Lists all pairs within the margin of each other where the tool is; false where there is no room
/// for them.
bool ToolProxy::list_pairs_once(double margin) noexcept
{
    pair_count_ = 0;
    travelled_ = 0; // so that what pairs have is not lost in its rounding
    list_margin_ = -1;
    for (std::size_t at = 0; at < objects_.size(); ++at) {
        SeenObject& object = objects_[at];
        object.look_at(pose_);
        object.listed = object.relative;
        object.first_pair = object.end_pair = static_cast<std::uint32_t>(pair_count_);
        // Balls that are far apart need no walk, and stay apart for as long.
        const Box& bounds = object.body.features.bounds();
        const double apart = (object.relative.translation - bounds.center()).norm() -
                             bounds.extent().norm() / 2 - tool_.features.reach();
        object.list_reach = std::max(margin, apart);
        if (apart > margin) continue;
        const NearRowsAnswer near = near_rows(object.body.index, tool_.index, object.relative,
                                              margin, std::span(rows_).subspan(pair_count_));
        effort_.spent += list_work + near.count / listed_pairs_per_work;
        if (!near.complete) return false;
        for (std::size_t i = 0; i < near.count; ++i) {
            NearPair& pair = pairs_[pair_count_ + i];
            const NearRows& rows = rows_[pair_count_ + i];
            pair.contacts = PairContacts::none;
            pair.reach = 0;
            pair.scene = object.body.index.parts().triangle(rows.a);
            pair.tool = tool_.index.parts().triangle(rows.b);
            for (const Vec3& corner : pair.tool.vertices)
                pair.reach = std::max(pair.reach, corner.norm());
            pair.scene_row = rows.a;
            pair.tool_row = rows.b;
            pair.object = static_cast<std::uint32_t>(at);
            set_normal(pair, rows.across);
            apart_until_[pair_count_ + i] = travelled_;
        }
        pair_count_ += near.count;
        object.end_pair = static_cast<std::uint32_t>(pair_count_);
    }
    list_margin_ = margin;
    ++work_.lists;
    work_.pairs = std::max(work_.pairs, pair_count_);
    return true;
}

/// Like list_pairs_once, within a margin that keeps lists short: the more pairs the last list had, the
/// smaller, and ever smaller where there is no room.
bool ToolProxy::list_pairs(double margin) noexcept
{
    const double least = least_margin_clearances * options_.clearance;
    if (list_margin_ > 0) {
        const std::size_t far_pairs = pair_count_ - std::min(near_count_, pair_count_);
        if (far_pairs > many_pairs) most_margin_ = std::max(0.5 * list_margin_, least);
        if (far_pairs < few_pairs) most_margin_ = std::max(2 * list_margin_, most_margin_);
    }
    margin = std::min(margin, most_margin_);
    while (margin >= least) {
        if (!list_pairs_once(margin)) {
            margin /= 2;
            most_margin_ = std::max(margin, least);
            continue;
        }
        return true;
    }
    return false;
}

/// How far an object may see points of the tool still move before a pair that is not listed could be too
/// near.
double ToolProxy::room(const SeenObject& object) const noexcept
{
    const double moved =
        twist_between(object.listed, object.relative).path_length(tool_.features.reach());
    return object.list_reach - options_.clearance - moved;
}

/// The least of all objects.
double ToolProxy::room() const noexcept
{
    if (list_margin_ < 0) return -1;
    double least = std::numeric_limits<double>::infinity();
    for (const SeenObject& object : objects_) least = std::min(least, room(object));
    return least;
}

/// The part of the move that ends before a pair that is not listed could be too near.
double ToolProxy::listed_part() const noexcept
{
    double part = 1;
    for (const SeenObject& object : objects_) {
        const double length = object.motion.twist.path_length(tool_.features.reach());
        const double space = std::max(room(object), 0.0);
        if (length > space) part = std::min(part, space / length);
    }
    return part;
}

/// Takes the contacts of a pair whose gap is more than `nearest` and at most `farthest`; false where
/// what is left of the tick's work is for the proof.
bool ToolProxy::add_contacts(std::uint32_t pair, double nearest, double farthest) noexcept
{
    const SeenObject& object = objects_[pairs_[pair].object];
    const bool is_plain = !object.body.features.row(pairs_[pair].scene_row).owns_any() ||
                          !tool_.features.row(pairs_[pair].tool_row).owns_any();
    if ((!is_plain || plain_count_++ % plain_pairs_per_work == 0) &&
        !effort_.begin(contacts_work, contacts_share))
        return false;
    const std::span<FeatureContact> free = std::span(contacts_).subspan(contact_count_);
    const std::size_t found = find_contacts(pairs_[pair], {&object.body.features, {}},
                                            {&tool_.features, object.relative}, farthest, free);
    for (const FeatureContact& contact : free.first(found)) {
        if (!(contact.gap > nearest)) continue;
        const FeatureContact local = contact;
        contacts_[contact_count_++] = {object.pose(local.scene_point),
                                       object.pose(local.tool_point),
                                       object.pose.rotation * local.normal,
                                       local.gap,
                                       pair,
                                       pairs_[pair].object,
                                       local.turns,
                                       object.pose.rotation * local.scene_edge,
                                       object.pose.rotation * local.tool_edge};
    }
    return true;
}

/// Takes the contacts of all pairs that are near.
void ToolProxy::collect_near() noexcept
{
    contact_count_ = 0;
    near_count_ = 0;
    plain_count_ = 0;
    const double near = near_clearances * options_.clearance;
    effort_.spent += pair_count_ / looks_per_work;
    bool has_room = true;
    for (std::uint32_t i = 0; i < pair_count_; ++i) {
        NearPair& pair = pairs_[i];
        pair.contacts = PairContacts::none;
        if (apart_until_[i] > travelled_ + near) continue;
        const RigidTransform& tool = objects_[pair.object].relative;
        if (pair.normal.isZero(0)) {
            NearPair* const without_plane = &pair;
            set_closest_planes(std::span(&without_plane, 1), tool);
        }
        const double gap = plane_gap(pair, tool);
        apart_until_[i] = travelled_ + gap;
        if (gap > near) continue;
        ++near_count_;
        pair.contacts = PairContacts::near;
        has_room = has_room && add_contacts(i, 0, near);
    }
}

/// Lists the pairs of an object of which no known plane keeps a gap of `least` all its motion long, but
/// for those whose contacts are all among the constraints.
std::span<NearPair*> ToolProxy::open_pairs(const SeenObject& object, double least,
                                           OpenPairs which) noexcept
{
    const ToolMotion& motion = object.motion;
    const double length = motion.twist.path_length(tool_.features.reach());
    effort_.spent += (object.end_pair - object.first_pair) / looks_per_work;
    std::size_t count = 0;
    for (std::uint32_t i = object.first_pair; i < object.end_pair; ++i) {
        if (apart_until_[i] >= travelled_ + length + least) continue;
        NearPair& pair = pairs_[i];
        if (which == OpenPairs::unconstrained && pair.contacts == PairContacts::all) continue;
        if (!stays_apart(pair, motion, least)) open_[count++] = &pair;
    }
    // A plane that serves one pair often serves its neighbours.
    std::size_t left = 0;
    Vec3 direction = Vec3::Zero();
    for (std::size_t first = 0; first < count; first += closest_planes_at_once) {
        const std::size_t begin = left;
        const std::size_t end = std::min(first + closest_planes_at_once, count);
        if (!effort_.begin(open_pairs_work, which == OpenPairs::all ? 1 : contacts_share)) {
            // What nobody had time to look at stays open to the proof.
            while (which == OpenPairs::all && first < count) open_[left++] = open_[first++];
            break;
        }
        for (std::size_t i = first; i < end; ++i)
            if (!find_plane(*open_[i], motion, least, direction)) open_[left++] = open_[i];
        const auto closest = std::span(open_).subspan(begin, left - begin);
        set_closest_planes(closest, motion.from);
        left = begin;
        for (NearPair* const pair : closest) {
            if (!pair->normal.isZero(0)) direction = pair->normal;
            if (!stays_apart(*pair, motion, least)) open_[left++] = pair;
        }
    }
    return std::span(open_).first(left);
}

/// Takes the contacts of all other pairs that the motion would bring too near; false where there are
/// none.
bool ToolProxy::collect_hit(const Move& motion) noexcept
{
    const std::size_t before = contact_count_;
    const double farthest = list_margin_ + motion.seen;
    const double near = near_clearances * options_.clearance;
    for (const SeenObject& object : objects_) {
        for (NearPair* const pair :
             open_pairs(object, 0.95 * options_.clearance, OpenPairs::unconstrained)) {
            const auto number = static_cast<std::uint32_t>(pair - pairs_.data());
            if (!add_contacts(number, pair->contacts == PairContacts::near ? near : 0, farthest))
                break;
            pair->contacts = PairContacts::all;
        }
    }
    return contact_count_ > before;
}

/// What of the objects' motions surely passes nothing: a contact that the constraints do not have is
/// stopped at before it is too near. An object that carries the tool sees no motion.
double ToolProxy::proven_part(const SeenObject* carrier) noexcept
{
    const double clearance = options_.clearance;
    const GapLimits limits = {0.95 * clearance, 0.9 * clearance, 0.5 * clearance};
    double part = 1;
    for (const SeenObject& object : objects_) {
        if (&object == carrier) continue;
        part = std::min(part, free_part(open_pairs(object, limits.wanted, OpenPairs::all),
                                        object.motion, limits, effort_));
    }
    return part;
}

} // namespace proxima
