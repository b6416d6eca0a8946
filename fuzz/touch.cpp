// A hand that goes anywhere over any triangles: the proxy passes none of them, by exact tests of every
// move, and has the same bits by an index as by a look at every triangle.
#include "base/check.h"
#include "decoded_mesh.h"
#include "haptics/proxy/proxy.h"
#include "haptics/scenes_to_touch.h"
#include "haptics/surface/contact_surface.h"
#include "proxima/mesh_index.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace {

using namespace proxima;

/// A place within three times the mesh's size about its middle.
Vec3 decode_hand(fuzz::Bytes& bytes, const fuzz::PositionCode& code, const TriangleMesh& mesh,
                 const Box& box)
{
    const Vec3 p = fuzz::decode_point(bytes, code, mesh);
    const Vec3 reach = Vec3::Constant(1.5 * box.extent().maxCoeff());
    return p.cwiseMax(box.center() - reach).cwiseMin(box.center() + reach);
}

/// The mesh turned, its coordinates rounded to so many binary digits of the largest: faces that lay in
/// one plane meet at seams that are all but flat.
TriangleMesh turned_and_rounded(const TriangleMesh& mesh, double angle, int digits)
{
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(angle, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    double most = 0;
    for (const Vec3& p : mesh.positions()) most = std::max(most, p.cwiseAbs().maxCoeff());
    if (!(most > 1e-300)) return mesh;
    const double step = std::ldexp(1.0, std::ilogb(most) + 1 - digits);
    std::vector<Vec3> positions;
    for (const Vec3& p : mesh.positions()) {
        const Vec3 q = turn * p;
        positions.emplace_back(Vec3{std::nearbyint(q.x() / step), std::nearbyint(q.y() / step),
                                    std::nearbyint(q.z() / step)} *
                               step);
    }
    const auto corners = mesh.triangles();
    return *make_triangle_mesh(std::move(positions), {corners.begin(), corners.end()});
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const std::uint8_t form = bytes.next();
    const fuzz::PositionCode code(bytes);
    const TriangleMesh decoded = fuzz::decode_mesh(bytes, code);
    const std::uint8_t turn = bytes.next();
    const TriangleMesh mesh =
        turn < 128 ? decoded : turned_and_rounded(decoded, turn / 40.0, 12 + turn % 32);
    const Box box = bounding_box(mesh);
    const MeshIndex index = build_mesh_index(mesh, {.execution = {.threads = {1}}}).value();
    const IndexContactSurface near(index);
    const MeshContactSurface all(mesh);
    ProxyOptions options;
    if (form % 2 != 0) options.radius = box.extent().maxCoeff() / (4 + form % 16);
    if (form % 4 >= 2) options.static_friction = options.dynamic_friction = 0.4;
    Proxy proxy(near, options);
    Proxy slow(all, options);
    Vec3 hand = decode_hand(bytes, code, mesh, box);
    proxy.place(hand);
    slow.place(hand);
    for (int stroke = 0; stroke < 8 && bytes.left() > 0; ++stroke) {
        const int ticks = 1 + bytes.next() % 8;
        const Vec3 from = hand;
        const Vec3 to = decode_hand(bytes, code, mesh, box);
        for (int tick = 1; tick <= ticks; ++tick) {
            hand =
                tick == ticks ? to : Vec3(from + static_cast<double>(tick) / ticks * (to - from));
            const ProxyTick& found = proxy.follow(hand);
            const ProxyTick& expected = slow.follow(hand);
            PROXIMA_CHECK_EQ(found.is_placed, expected.is_placed);
            PROXIMA_CHECK(found.proxy == expected.proxy && found.anchor == expected.anchor);
            PROXIMA_CHECK(found.anchor.allFinite());
            const auto path = proxy.path();
            for (std::size_t i = 1; i < path.size(); ++i)
                PROXIMA_CHECK(!proxima::testing::passes(mesh, path[i - 1], path[i]));
        }
    }
    return 0;
}
