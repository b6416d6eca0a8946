#include "haptics/force/penalty_probe.h"

#include "base/check.h"
#include "proxima/haptic_renderer.h"
#include "proxima/signed_distance.h"

namespace proxima {

PenaltyProbe::PenaltyProbe(const MeshIndex& index) : index_(index)
{
    PROXIMA_CHECK(index.has_signs());
}

void PenaltyProbe::place(const Vec3& p) noexcept
{
    tick_ = {};
    tick_.proxy = tick_.anchor = p;
    popped_ = false;
    path_size_ = 0;
}

const ProxyTick& PenaltyProbe::follow(const Vec3& p) noexcept
{
    const ProxyTick last = tick_;
    place(p);
    const SignedDistance at = *signed_distance(index_, p);
    const Vec3 out = at.closest.point - p;
    const double depth = out.norm();
    if (!(at.distance < 0) || !(depth > 0)) {
        if (last.hold == Hold::free) {
            path_ = {last.proxy, p};
            path_size_ = 2;
        }
        return tick_;
    }
    tick_.hold = Hold::sliding;
    tick_.anchor = at.closest.point;
    tick_.normal = out / depth;
    tick_.depth = depth;
    Contact& contact = tick_.slide.contacts[0];
    contact.normal = tick_.normal;
    contact.point = at.closest.point;
    contact.triangle = at.closest.triangle;
    contact.pressure = depth;
    tick_.slide.contact_count = 1;
    tick_.slide.center = p;
    tick_.slide.anchor = at.closest.point;
    popped_ = last.hold != Hold::free && tick_.normal.dot(last.normal) < 0;
    return tick_;
}

} // namespace proxima
