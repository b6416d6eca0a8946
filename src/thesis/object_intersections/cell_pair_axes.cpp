#include "thesis/object_intersections/cell_pair_axes.h"

namespace proxima {
namespace {

// Forward error, u = 2^-53, of the axes as computed: any axis is a good one, whatever rounding made
// of it. S = sum over k of |L_k| (|T| + |R| M_B + M_A)_k, M = |lower| + edge of each frame, is the
// size of all that is added up.
//     planes of cells: lower + part edge, rounded twice           2.1 u M for either frame
//     root: cB = lower + edge / 2, R cB + T - cA, then L . that  10 u S
//     steps: L . (R edge) / 4 and so on, 6 u, all levels together 3 u S
//     38 additions of steps, each rounding what is below S       38 u S
//     alpha, beta and their sum                                   9 u S
// Together below 64 u S; S is computed to 16 u of itself. Products that underflow lose less than
// `underflow`; where something overflows, no comparison says that cells are apart.
constexpr double center_rounding = 80 * 0x1p-53;
constexpr double underflow = 0x1p-1000;

std::array<Vec3, CellPairAxes::axis_count> axes_of(const Mat3& rotation) noexcept
{
    std::array<Vec3, CellPairAxes::axis_count> axes;
    std::size_t count = 0;
    for (int i = 0; i < 3; ++i) {
        axes[count++] = Vec3::Unit(i);
        // Across two edges, not along the third: the pose may be a little askew.
        axes[count++] = rotation.col((i + 1) % 3).cross(rotation.col((i + 2) % 3));
        for (int j = 0; j < 3; ++j) axes[count++] = Vec3::Unit(i).cross(rotation.col(j));
    }
    return axes;
}

} // namespace

CellPairAxes::CellPairAxes(const OctreeFrame& a, const OctreeFrame& b,
                           const RigidTransform& pose_b) noexcept
{
    const Vec3 between = pose_b(b.lower + 0.5 * b.edge) - (a.lower + 0.5 * a.edge);
    const Mat3 sizes = pose_b.rotation.cwiseAbs();
    const Vec3 size = pose_b.translation.cwiseAbs() + sizes * (b.lower.cwiseAbs() + b.edge) +
                      (a.lower.cwiseAbs() + a.edge);
    const auto axes = axes_of(pose_b.rotation);
    for (std::size_t i = 0; i < axis_count; ++i) {
        const Vec3& axis = axes[i];
        const Vec3 along_a = axis.cwiseProduct(a.edge);
        const Vec3 along_b = (pose_b.rotation.transpose() * axis).cwiseProduct(b.edge);
        root_[i] = axis.dot(between);
        alpha_[i] = 0.5 * along_a.cwiseAbs().sum();
        beta_[i] = 0.5 * along_b.cwiseAbs().sum();
        error_[i] = center_rounding * axis.cwiseAbs().dot(size) + underflow;
        for (unsigned octant = 0; octant < 8; ++octant) {
            const Vec3 side((octant & 1U) != 0 ? 0.25 : -0.25, (octant & 2U) != 0 ? 0.25 : -0.25,
                            (octant & 4U) != 0 ? 0.25 : -0.25);
            child_of_a_[octant][i] = -side.dot(along_a);
            child_of_b_[octant][i] = side.dot(along_b);
        }
    }
}

} // namespace proxima
