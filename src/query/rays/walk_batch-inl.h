// Many rays on their way through a mesh index at once. Included once per target.
//
//     nodes   -> nodes, leaves or leaving     each list is worked off as a whole, so that a
//     leaves  -> leaving                      processor overlaps its rays: nothing has to be
//     leaving -> nodes, leaves or ended       guessed between two of them, and the block that a ray
//     ended   -> the next ray of the batch    comes to is fetched while the others go on

#if defined(PROXIMA_QUERY_WALK_BATCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PROXIMA_QUERY_WALK_BATCH_INL_H
#undef PROXIMA_QUERY_WALK_BATCH_INL_H
#else
#define PROXIMA_QUERY_WALK_BATCH_INL_H
#endif

#include "index/index_parts.h"
#include "query/rays/intersect_lanes-inl.h"
#include "query/rays/prepare_ray-inl.h"
#include "query/rays/walk_packet-inl.h"
#include "query/rays/walk_ray-inl.h"

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace proxima::HWY_NAMESPACE {

/// Rays under way at once.
inline constexpr std::size_t rays_together = 32;

/// Rays that wait for the same.
class RayList {
public:
    [[nodiscard]] HWY_INLINE std::size_t size() const { return size_; }
    [[nodiscard]] HWY_INLINE RayTraversal& operator[](std::size_t i) const { return *rays_[i]; }
    HWY_INLINE void clear() { size_ = 0; }
    /// Without a branch: a ray that does not wait is overwritten by the next.
    HWY_INLINE void push_if(bool waits, RayTraversal& ray)
    {
        rays_[size_] = &ray;
        size_ += waits ? 1 : 0;
    }

private:
    std::array<RayTraversal*, rays_together + 1> rays_{};
    std::size_t size_ = 0;
};

/// leave(), of eight blocks put aside at a time.
HWY_INLINE void leave_by_eights(const RayTraversal& ray, WalkState& at)
{
    if constexpr (ray_lanes == 8) {
        const RayTag d;
        const auto most = hn::Set(d, ray.most);
        while (true) {
            const std::uint32_t first = at.pending - 8;
            const std::uint32_t near =
                mask_bits(hn::Le(hn::LoadU(d, ray.nearness.data() + first), most));
            at.pending = first;
            if (near == 0) continue;
            at.pending += static_cast<std::uint32_t>(31 - std::countl_zero(near));
            at.next = ray.references[at.pending];
            return;
        }
    } else {
        leave(ray, at);
    }
}

using PacketBits = std::bitset<RaySource::most_rays / packet_size>;

template <class Search>
class BatchWalk {
public:
    /// Walks the rays of the source but those of packets answered already: a bit each.
    HWY_INLINE BatchWalk(const IndexParts& index, const Search& search, const RaySource& source,
                         const PacketBits& answered)
        : index_(index), blocks_(index.blocks().data()), search_(search), source_(source),
          answered_(answered), hits_(index, source)
    {}

    HWY_INLINE void run()
    {
        for (RayTraversal& ray : rays_)
            if (!open_next(ray)) break;
        while (nodes_.size() + leaves_.size() > 0) {
            while (nodes_.size() > 0 && leaves_.size() + leaving_.size() < rays_together / 2)
                enter_nodes();
            look_at_leaves();
            leave_blocks();
            replace_ended();
        }
        hits_.answer();
    }

private:
    PROXIMA_STEP bool open_next(RayTraversal& ray)
    {
        while (next_ < source_.rays.size()) {
            if (next_ % packet_size == 0 && answered_.test(next_ / packet_size)) {
                next_ += packet_size;
                continue;
            }
            const Ray& own = source_.rays[next_];
            const auto number = static_cast<std::uint32_t>(next_++);
            const RayStart start = open_any_ray(index_, own, source_.faces, ray);
            if (start == RayStart::ready) {
                ray.number = number;
                go_to(ray, ray.at);
                return true;
            }
            source_.refuse(source_.context, number, start);
        }
        return false;
    }

    HWY_INLINE void go_to(RayTraversal& ray, WalkState at)
    {
        ray.at = at;
        prefetch_block(blocks_[at.next & ~index_leaf_bit]);
        const bool is_leaf = (at.next & index_leaf_bit) != 0;
        nodes_.push_if(!is_leaf, ray);
        leaves_.push_if(is_leaf, ray);
    }

    HWY_INLINE void enter_nodes()
    {
        const std::size_t count = nodes_.size();
        nodes_.clear();
        for (std::size_t i = 0; i < count; ++i) {
            RayTraversal& ray = nodes_[i];
            WalkState at = ray.at;
            const IndexNode& node = blocks_[at.next].node;
            const MetChildren met = meet_children(node, ray);
            enter_nearest(node, met, ray, at);
            ray.at = at;
            prefetch_block(blocks_[at.next & ~index_leaf_bit]);
            const bool leaves = met.bits == 0;
            const bool is_leaf = (at.next & index_leaf_bit) != 0;
            nodes_.push_if(!leaves && !is_leaf, ray);
            leaves_.push_if(!leaves && is_leaf, ray);
            leaving_.push_if(leaves, ray);
        }
    }

    HWY_INLINE void look_at_leaves()
    {
        std::array<std::uint32_t, rays_together> with_candidates; // indices in leaves_
        std::size_t candidate_count = 0;
        for (std::size_t i = 0; i < leaves_.size(); ++i) {
            LeafCandidates& candidates = candidates_[i];
            candidates.lanes = 0;
            candidates.sure = 0;
            const std::uint32_t block = leaves_[i].at.next & ~index_leaf_bit;
            look_at_leaf<LeafWork::whole>(blocks_[block].leaf, leaves_[i], candidates);
            with_candidates[candidate_count] = static_cast<std::uint32_t>(i);
            candidate_count += candidates.lanes != 0 ? 1 : 0;
            leaving_.push_if(true, leaves_[i]);
        }
        for (std::size_t k = 0; k < candidate_count; ++k) {
            RayTraversal& ray = leaves_[with_candidates[k]];
            const std::uint32_t block = ray.at.next & ~index_leaf_bit;
            const bool goes_on = search_.take(block, candidates_[with_candidates[k]], ray);
            if (!goes_on) ray.at.pending = RayTraversal::bottom;
        }
        leaves_.clear();
    }

    HWY_INLINE void leave_blocks()
    {
        for (std::size_t i = 0; i < leaving_.size(); ++i) {
            RayTraversal& ray = leaving_[i];
            WalkState at = ray.at;
            leave_by_eights(ray, at);
            ray.at = at;
            prefetch_block(blocks_[at.next & ~index_leaf_bit]);
            const bool ends = at.next == RayTraversal::end;
            const bool is_leaf = (at.next & index_leaf_bit) != 0;
            nodes_.push_if(!is_leaf, ray);
            leaves_.push_if(is_leaf && !ends, ray);
            ended_.push_if(ends, ray);
        }
        leaving_.clear();
    }

    HWY_INLINE void replace_ended()
    {
        for (std::size_t i = 0; i < ended_.size(); ++i) {
            RayTraversal& ray = ended_[i];
            if (Search::notes_hits && !ray.found && ray.best_noted.leaf != RayTriangle::no_leaf) {
                hits_.add(ray.number, ray.shear, ray.best_noted);
            } else {
                search_.settle(ray);
                source_.answer(source_.context, ray.number, ray.found ? &ray.best : nullptr);
            }
            (void)open_next(ray);
        }
        ended_.clear();
    }

    const IndexParts& index_;
    const IndexBlock* blocks_;
    const Search& search_;
    const RaySource& source_;
    const PacketBits& answered_;
    std::size_t next_ = 0; ///< of the source's rays
    std::array<RayTraversal, rays_together> rays_;
    std::array<LeafCandidates, rays_together> candidates_;
    RayList nodes_;
    RayList leaves_;
    RayList leaving_;
    RayList ended_;
    HitLanes hits_;
};

/// Those that go alike as packets, then all others in turns.
template <class Search>
HWY_INLINE void walk_together(const IndexParts& index, const Search& search,
                              const RaySource& source)
{
    PacketBits answered;
    if constexpr (Search::has_packets && ray_lanes > 1) {
        PacketWalk<Search> packet(index, search, source);
        for (std::size_t i = 0; i + packet_size <= source.rays.size(); i += packet_size)
            if (packet.run(i)) answered.set(i / packet_size);
        packet.end();
    }
    BatchWalk<Search>(index, search, source, answered).run();
}

} // namespace proxima::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
