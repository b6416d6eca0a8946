// A hand among objects of any triangles, which move, deform and are exchanged: the proxy passes no
// triangle of any object, neither while they move nor as they stand.
#include "base/check.h"
#include "decoded_mesh.h"
#include "geometry/exact_predicates.h"
#include "haptics/changing_shapes.h"
#include "haptics/scenes_to_touch.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace {

using namespace proxima;
using namespace proxima::testing;

constexpr double size_of_models = 1.0 / 32; ///< of their code
const Box bounds{Vec3(-4, -4, -4), Vec3(4, 4, 4)};

Vec3 decode_place(fuzz::Bytes& bytes)
{
    const double x = bytes.next_signed();
    const double y = bytes.next_signed();
    const double z = bytes.next_signed();
    return Vec3{x, y, z} / 128;
}

RigidTransform decode_pose(fuzz::Bytes& bytes)
{
    const Vec3 axis(1, bytes.next_signed(), bytes.next_signed());
    const double angle = bytes.next() / 40.0;
    const Vec3 place = decode_place(bytes);
    return posed(angle, axis, place);
}

/// Turned as well where the byte says so, and rounded: faces of one plane are then all but flat.
TriangleMesh decode_model(fuzz::Bytes& bytes, const fuzz::PositionCode& code)
{
    const TriangleMesh mesh = fuzz::decode_mesh(bytes, code);
    const std::uint8_t turn = bytes.next();
    const Mat3 rotation = posed(turn / 40.0, Vec3(1, 2, 3), Vec3::Zero()).rotation;
    return moved(mesh, [&](const Vec3& p) {
        Vec3 q = size_of_models * p;
        if (turn < 128) return q;
        q = rotation * q;
        for (double& x : q) x = static_cast<double>(static_cast<float>(x));
        return q;
    });
}

/// Each vertex moved by up to `amount`.
std::vector<Vec3> bent(const TriangleMesh& mesh, double amount, std::uint32_t seed)
{
    std::vector<Vec3> result(mesh.positions().begin(), mesh.positions().end());
    const auto number = [&] {
        seed = seed * 1664525U + 1013904223U;
        return static_cast<double>(seed >> 8U) * 0x1p-23 - 1;
    };
    for (Vec3& p : result) {
        for (double& x : p) x += amount * number();
    }
    return result;
}

struct Object {
    ObjectId id{};
    TouchBody body;
    Vertices vertices;
    bool exchanged = false;
    bool deforms = false;
};

/// What the application does before a tick.
void change(TouchScene& scene, Object& object, fuzz::Bytes& bytes, const TouchBody& other)
{
    const std::uint8_t what = bytes.next();
    if (what % 4 == 0) return;
    if (what % 4 == 1) {
        PROXIMA_CHECK(scene.move(
            object.id, {.pose = decode_pose(bytes), .seconds = tick_seconds * (what / 4 % 16)}));
    } else if (what % 4 == 2) {
        const double amount = std::ldexp(1.0, -(what / 4 % 32));
        const auto positions = bent(object.body.mesh(), amount, bytes.next());
        const double seconds = tick_seconds * (bytes.next() % 8);
        const auto shape = refit_touch_body(object.body, positions);
        PROXIMA_CHECK(shape && scene.deform(object.id, *shape, seconds));
        object.vertices.deform(positions, seconds);
        object.deforms = true;
    } else if (what >= 192) {
        PROXIMA_CHECK(scene.exchange(object.id, other));
        object.body = other;
        object.vertices = Vertices(object.body.mesh());
        object.exchanged = true;
        object.deforms = false;
    }
}

void check_tick(const TouchScene& scene, const HapticRenderer& renderer,
                std::span<const Object> objects, const Vec3& before)
{
    const RenderTick& felt = renderer.last();
    PROXIMA_CHECK(felt.force.allFinite());
    if (!felt.is_placed) return;
    const std::span<const Vec3> carried = parts_of(renderer).carried_path();
    const std::span<const Vec3> path = renderer.path();
    bool exchanged = false;
    for (const Object& object : objects) exchanged = exchanged || object.exchanged;
    for (const Object& object : objects) {
        const SceneObject now = moving_surface(scene).object(object.id);
        const auto local = [&](const Vec3& p) { return to_local(now.now, p); };
        const auto passes = [&](const Vec3& from, const Vec3& to) {
            return object.deforms ? object.vertices.passes_at_rest(std::vector<Vec3>{from, to})
                                  : passes_object(now, from, to);
        };
        if (!carried.empty() && !exchanged) {
            const Vec3 from = to_local(now.before, before);
            const Vec3 to = local(carried.front());
            PROXIMA_CHECK(!(now.changed ? object.vertices.passes_while_changing(from, to)
                                        : passes(from, to)));
            for (std::size_t i = 1; i < carried.size(); ++i)
                PROXIMA_CHECK(!passes(local(carried[i - 1]), local(carried[i])));
            if (!path.empty()) PROXIMA_CHECK(path.front() == carried.back());
        }
        for (std::size_t i = 1; i < path.size(); ++i)
            PROXIMA_CHECK(!passes(local(path[i - 1]), local(path[i])));
        if (!path.empty()) {
            const double radius = parts_of(renderer).proxy().radius();
            PROXIMA_CHECK_GE(object.vertices.distance(local(felt.proxy)), radius - 1e-11);
        }
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    fuzz::Bytes bytes({data, size});
    const std::uint8_t form = bytes.next();
    const std::uint8_t grid = bytes.next() & 12U; // whole numbers of moderate size
    fuzz::Bytes code_bytes({&grid, 1});
    const fuzz::PositionCode code(code_bytes);
    TouchScene scene(bounds);
    std::vector<Object> objects;
    for (int i = 0; i < 1 + form % 3; ++i) {
        const TouchBody body = body_of(decode_model(bytes, code));
        const auto id = scene.add(body, decode_pose(bytes));
        PROXIMA_CHECK(id);
        objects.push_back({*id, body, Vertices(body.mesh())});
    }
    const TouchBody other = body_of(decode_model(bytes, code));
    HapticRenderer renderer = make_haptic_renderer(scene, same_unit, strong_device(),
                                                   plain(form / 4 % 2 * 0.4, form / 8 % 2 * 0.02))
                                  .value();
    Vec3 hand = decode_place(bytes);
    for (int stroke = 0; stroke < 8 && bytes.left() > 0; ++stroke) {
        const int ticks = 1 + bytes.next() % 8;
        const Vec3 from = hand;
        hand = decode_place(bytes);
        for (int tick = 1; tick <= ticks; ++tick) {
            for (Object& object : objects) {
                object.exchanged = false;
                change(scene, object, bytes, other);
                object.vertices.advance();
            }
            const Vec3 before = renderer.last().proxy;
            const bool was_placed = renderer.last().is_placed && stroke + tick > 1;
            (void)renderer.tick(at(from + static_cast<double>(tick) / ticks * (hand - from)),
                                tick_seconds);
            if (was_placed) check_tick(scene, renderer, objects, before);
        }
    }
    return 0;
}
