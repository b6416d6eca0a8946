#include "query/closest/soak/sign_check.h"

#include "base/text.h"
#include "octree/winding_number.h"
#include "proxima/signed_distance.h"

#include <algorithm>
#include <cmath>

namespace proxima::soak {

void SignTally::add(const SignTally& other)
{
    points += other.points;
    wrong += other.wrong;
    inside += other.inside;
    undecided += other.undecided;
    if (first_wrong.empty()) first_wrong = other.first_wrong;
}

SignCheck::SignCheck(const TriangleMesh& mesh, const MeshIndex& index, bool closed)
    : mesh_(mesh), index_(index)
{
    if (closed) columns_.emplace(mesh);
    const Box box = bounding_box(mesh);
    size_ = box.extent().norm() + box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).maxCoeff();
}

std::optional<bool> SignCheck::is_inside(const Vec3& p) const
{
    if (columns_) {
        const auto winding = columns_->at(p);
        if (!winding) return std::nullopt;
        return *winding >= 1;
    }
    const double winding = brute_winding_number(mesh_, p);
    if (std::abs(winding - 0.5) < 1e-9) return std::nullopt;
    return winding > 0.5;
}

SignTally SignCheck::check(std::span<const Vec3> points) const
{
    SignTally tally;
    for (const Vec3& p : points) {
        const SignedDistance found = signed_distance(index_, p).value();
        const auto truth = is_inside(p);
        if (!truth || std::abs(found.distance) < 1e-14 * size_) {
            ++tally.undecided;
            continue;
        }
        ++tally.points;
        if (*truth) ++tally.inside;
        if ((found.distance < 0) == *truth) continue;
        ++tally.wrong;
        if (!tally.first_wrong.empty()) continue;
        tally.first_wrong = concat("sign by ", name_of(found.method), ": distance ", found.distance,
                                   " (point ", p.x(), " ", p.y(), " ", p.z(), ")");
    }
    return tally;
}

} // namespace proxima::soak
