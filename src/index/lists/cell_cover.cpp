#include "index/lists/cell_cover.h"

#include <algorithm>
#include <bit>

namespace proxima {

void RankSet::clear(std::size_t count)
{
    const std::size_t needed = std::bit_ceil(2 * count + 2);
    if (slots_.size() < needed || ++epoch_ == 0) {
        slots_.assign(std::max(needed, slots_.size()), Slot{});
        epoch_ = 1;
        shift_ = 64U - static_cast<unsigned>(std::bit_width(slots_.size() - 1));
    }
}

std::size_t RankSet::slot_of(std::uint32_t rank) const noexcept
{
    const std::uint64_t spread = std::uint64_t{rank} * 0x9E3779B97F4A7C15U;
    std::size_t slot = spread >> shift_;
    while (slots_[slot].epoch == epoch_ && slots_[slot].rank != rank)
        slot = (slot + 1) & (slots_.size() - 1);
    return slot;
}

bool RankSet::insert(std::uint32_t rank) noexcept
{
    Slot& slot = slots_[slot_of(rank)];
    if (slot.epoch == epoch_) return false;
    slot = {rank, epoch_};
    return true;
}

bool RankSet::contains(std::uint32_t rank) const noexcept
{
    return slots_[slot_of(rank)].epoch == epoch_;
}

void cover_features(const LocalFeatures& features, std::span<const std::uint32_t> list,
                    RankSet& taken, std::vector<std::uint32_t>& cover)
{
    cover.clear();
    taken.clear(list.size());
    for (const std::uint32_t id : list) {
        const LocalFeature& feature = features.features[id];
        if (feature.kind != FeatureKind::face) continue;
        const std::uint32_t rank = features.triangles(feature).front();
        taken.insert(rank);
        cover.push_back(rank);
    }
    const auto faces = static_cast<std::ptrdiff_t>(cover.size());
    // Edges before vertices: a triangle taken for an edge covers the edge's ends.
    for (const FeatureKind kind : {FeatureKind::edge, FeatureKind::vertex}) {
        for (const std::uint32_t id : list) {
            const LocalFeature& feature = features.features[id];
            if (feature.kind != kind) continue;
            const std::span<const std::uint32_t> triangles = features.triangles(feature);
            if (std::ranges::any_of(triangles,
                                    [&](std::uint32_t rank) { return taken.contains(rank); })) {
                continue;
            }
            taken.insert(triangles.front());
            cover.push_back(triangles.front());
        }
    }
    if (faces != std::ssize(cover)) std::ranges::sort(cover);
}

} // namespace proxima
