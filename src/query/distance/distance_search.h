// A search for the closest triangles of two indexes, under way.
//
//     frame   axes of A's coordinates, about A's center, in units of the larger mesh's size:
//             x = a_scale p for points p of A's blocks, x = R (b_scale q) + offset for points q of
//             B's
#pragma once

#include "base/progress.h"
#include "index/index_parts.h"
#include "proxima/mesh_distance.h"
#include "query/distance/near_rows.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace proxima {

/// What is in a block, as boxes: by centers and half extents in units of the frame, along the axes
/// of its own mesh and about its center.
struct BlockBox {
    std::array<float, 3> center;
    std::array<float, 3> half;
};

/// Two blocks to be looked into, at least `bound` apart, squared.
struct PendingPair {
    double bound;
    std::uint32_t reference_a;
    std::uint32_t reference_b;
    BlockBox box_a;
    BlockBox box_b;
};

/// Two triangles, and what lanes say of their distance in the frame.
struct NotedPair {
    double least;
    double most;
    std::uint32_t row_a;
    std::uint32_t row_b;
};

/// From how many sizes between the centers on, or times the smaller one's size, lanes are doubles;
/// from how many sizes any pair as close as the closest one, up to rounding, will do; and from how
/// many all pairs are.
inline constexpr double near_reach = 32;
inline constexpr double far_reach = 0x1p26;
inline constexpr double farthest_reach = 0x1p60;

/// Pairs that a search keeps instead of looking for the closest one.
struct NearRowsList {
    std::span<NearRows> rows;
    NearRowsAnswer answer;
};

/// The pose in the frame, and the closest pair so far.
class PROXIMA_HIDDEN DistanceSearch {
public:
    /// Looks for pairs at most `farthest` apart.
    DistanceSearch(const IndexParts& a, const IndexParts& b, const RigidTransform& pose_b,
                   double farthest) noexcept;

    /// Ends walks once it is cancelled. May be null.
    void watch(const Progress* progress) noexcept { progress_ = progress; }
    [[nodiscard]] bool is_cancelled() const noexcept { return proxima::is_cancelled(progress_); }

    /// From now on every noted pair is added to the list, and none is asked.
    void keep_all(NearRowsList& list) noexcept { kept_ = &list; }

    /// Compares the best pair with that of these rows, in doubles. Returns true where they touch.
    bool ask(std::uint32_t row_a, std::uint32_t row_b) noexcept;

    /// Keeps a pair in mind to be asked by settle(), if it is not sure to be beaten by then; one
    /// that may touch is asked at once. `nearest` points from one to the other. Returns true where
    /// they touch.
    bool note(const NotedPair& pair, const Vec3& nearest) noexcept;

    /// Asks all noted pairs that are not beaten. Returns true where two touch.
    bool settle() noexcept;

    [[nodiscard]] bool found() const noexcept { return found_; }
    [[nodiscard]] bool needs_doubles() const noexcept
    {
        return reach_ > near_reach || a_scale < 1 / near_reach || b_scale < 1 / near_reach;
    }
    [[nodiscard]] bool needs_no_walk() const noexcept { return !(reach_ < farthest_reach); }
    /// Distances in the frame beyond which pairs are of no interest, whatever floats or doubles
    /// round; its own rounding is less than that, too.
    [[nodiscard]] double limit() const noexcept { return limit_; }
    [[nodiscard]] const MeshDistance& best() const noexcept { return best_; }

    const IndexParts& a;
    const IndexParts& b;
    float a_scale = 1;
    float b_scale = 1;
    Mat3 rotation;
    Vec3 offset;
    /// From the closest point of A found so far to that of B; zero before there is one.
    [[nodiscard]] const Vec3& direction() const noexcept { return direction_; }

private:
    void lower_limit(double distance) noexcept;

    static constexpr std::size_t most_noted = 64;

    const RigidTransform& pose_b_;
    double scale_;
    double unit_ = 1; ///< makes lengths whose squares doubles do not hold middling numbers
    double reach_ = 0;
    double margin_ = 0;
    double limit_ = std::numeric_limits<double>::infinity();
    Vec3 direction_ = Vec3::Zero();
    std::array<NotedPair, most_noted> noted_;
    std::size_t noted_count_ = 0;
    double best_squared_;
    double farthest_;
    bool found_ = false;
    NearRowsList* kept_ = nullptr;
    const Progress* progress_ = nullptr;
    MeshDistance best_;
};

} // namespace proxima
