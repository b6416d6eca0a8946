// One number for every feature of a mesh: vertices, then edges, then faces.
#pragma once

#include "proxima/topology.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace proxima {

inline constexpr std::array all_feature_kinds = {FeatureKind::vertex, FeatureKind::edge,
                                                 FeatureKind::face};

/// The numbers of a mesh's features, in the order of Feature. \pre all together fit 32 bits
class FeatureNumbers {
public:
    FeatureNumbers() = default;
    explicit FeatureNumbers(const Topology& topology) noexcept
        : first_{0, static_cast<std::uint32_t>(topology.vertex_count()),
                 static_cast<std::uint32_t>(topology.vertex_count() + topology.edge_count()),
                 static_cast<std::uint32_t>(topology.vertex_count() + topology.edge_count() +
                                            topology.triangle_count())}
    {}

    /// How many features there are.
    [[nodiscard]] std::uint32_t count() const noexcept { return first_[3]; }

    /// The number of the kind's first feature.
    [[nodiscard]] std::uint32_t first(FeatureKind kind) const noexcept
    {
        return first_[static_cast<std::size_t>(kind)];
    }
    /// One past the number of the kind's last feature.
    [[nodiscard]] std::uint32_t end(FeatureKind kind) const noexcept
    {
        return first_[static_cast<std::size_t>(kind) + 1];
    }

    [[nodiscard]] std::uint32_t number(Feature feature) const noexcept
    {
        return first(feature.kind) + feature.id;
    }

    /// \pre number < count()
    [[nodiscard]] Feature feature(std::uint32_t number) const noexcept
    {
        const FeatureKind kind = number < first_[1]   ? FeatureKind::vertex
                                 : number < first_[2] ? FeatureKind::edge
                                                      : FeatureKind::face;
        return {kind, number - first(kind)};
    }

private:
    std::array<std::uint32_t, 4> first_ = {};
};

} // namespace proxima
