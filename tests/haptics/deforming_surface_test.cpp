// Objects whose shape changes while they are touched: nothing is passed, by every triangle.
#include "counted_allocations.h"
#include "geometry/triangle_contact.h"
#include "haptics/force/surface_renderer.h"
#include "haptics/scene/touch_access.h"
#include "haptics/scenes_to_touch.h"
#include "proxima/device.h"
#include "proxima/haptic_renderer.h"
#include "proxima/touch_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace proxima {
namespace {

using namespace testing;

constexpr double tick_seconds = 1e-3;
constexpr double frame_seconds = 1.0 / 60;

const WorkspaceMap same_unit{};
const Box room{Vec3(-1, -1, -1), Vec3(1, 1, 1)};

DeviceLimits strong_device()
{
    return {.name = "strong",
            .max_force = 1e4,
            .max_stiffness = 1e5,
            .max_damping = 100,
            .workspace_radius = 1};
}

RenderOptions plain(double friction, double radius)
{
    RenderOptions options;
    options.force = {.stiffness = 500, .damping = 0, .max_slew = 1e9, .start_seconds = 0};
    options.proxy_radius = radius;
    options.static_friction = friction;
    options.dynamic_friction = 0.75 * friction;
    options.guard = Guard::off;
    options.max_jump = 10;
    return options;
}

DeviceState at(const Vec3& p)
{
    DeviceState state;
    state.pose.translation = p;
    return state;
}

/// A cloth of 20 cm, flat, of 2 cells^2 triangles.
TriangleMesh flat_cloth(std::uint32_t cells)
{
    return moved(bumpy_sheet(cells),
                 [](const Vec3& p) { return Vec3(0.1 * p.x(), 0.1 * p.y(), 0); });
}

/// A wave that runs over a cloth in a direction.
struct Wave {
    double height;
    double hertz;
    double length;
    double phase;
    double direction;

    [[nodiscard]] std::vector<Vec3> positions(const TriangleMesh& flat, double seconds) const
    {
        constexpr double turn = 2 * std::numbers::pi;
        std::vector<Vec3> result(flat.positions().begin(), flat.positions().end());
        for (Vec3& p : result) {
            const double along = std::cos(direction) * p.x() + std::sin(direction) * p.y();
            const double angle = turn * (along / length - hertz * seconds) + phase;
            p += height * Vec3(0.3 * std::cos(angle), 0.2 * std::sin(angle), std::sin(angle));
        }
        return result;
    }
};

double determinant(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return a.dot(b.cross(c));
}

/// Whether a point that moves evenly meets a triangle whose corners do. The volume that both span is
/// a cubic polynomial of time, here by its Bernstein coefficients: where all of a part have one sign,
/// it is not zero there. Parts with both signs are halved.
class Crossing {
public:
    Crossing(const Triangle& before, const Triangle& now, const Vec3& from, const Vec3& to)
    {
        for (int k = 0; k < 3; ++k) {
            begin_[k] = before[k] - from;
            end_[k] = now[k] - to;
        }
    }

    [[nodiscard]] bool happens() const
    {
        const auto& [a, b, c] = begin_;
        const auto& [d, e, f] = end_;
        return search({determinant(a, b, c),
                       (determinant(a, b, f) + determinant(a, e, c) + determinant(d, b, c)) / 3,
                       (determinant(a, e, f) + determinant(d, b, f) + determinant(d, e, c)) / 3,
                       determinant(d, e, f)},
                      0, 1, 0);
    }

private:
    using Bernstein = std::array<double, 4>;

    [[nodiscard]] bool search(const Bernstein& v, double first, double last, int depth) const
    {
        const auto [least, most] = std::ranges::minmax(v);
        if (least > 0 || most < 0) return false;
        if (depth == 40) return is_inside(0.5 * (first + last));
        const double ab = (v[0] + v[1]) / 2;
        const double bc = (v[1] + v[2]) / 2;
        const double cd = (v[2] + v[3]) / 2;
        const double abc = (ab + bc) / 2;
        const double bcd = (bc + cd) / 2;
        const double middle = (abc + bcd) / 2;
        const double half = 0.5 * (first + last);
        return search({v[0], ab, abc, middle}, first, half, depth + 1) ||
               search({middle, bcd, cd, v[3]}, half, last, depth + 1);
    }

    /// Whether the point, which is in the triangle's plane then, is in the triangle.
    [[nodiscard]] bool is_inside(double t) const
    {
        std::array<Vec3, 3> corner;
        for (std::size_t k = 0; k < 3; ++k) corner[k] = begin_[k] + t * (end_[k] - begin_[k]);
        const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 across = corner[k].cross(corner[(k + 1) % 3]);
            if (across.dot(normal) < 0) return false;
        }
        return true;
    }

    std::array<Vec3, 3> begin_; ///< the corners as the point sees them
    std::array<Vec3, 3> end_;
};

bool is_beside(const Box& box, const Vec3& from, const Vec3& to)
{
    return (from.cwiseMax(to).array() < box.lower.array()).any() ||
           (from.cwiseMin(to).array() > box.upper.array()).any();
}

/// What every vertex does, apart from the library.
class Vertices {
public:
    explicit Vertices(const TriangleMesh& mesh)
        : mesh_(mesh), before_(mesh.positions().begin(), mesh.positions().end()), now_(before_),
          from_(before_), to_(before_), given_(before_)
    {}

    void deform(const std::vector<Vec3>& positions, double seconds)
    {
        from_ = given_;
        to_ = given_ = positions;
        seconds_ = seconds;
        ticks_ = 0;
    }

    void advance()
    {
        ++ticks_;
        const double passed = ticks_ * tick_seconds;
        const double part = passed < seconds_ * (1 - 1e-9) ? passed / seconds_ : 1;
        before_ = now_;
        for (std::size_t i = 0; i < now_.size(); ++i)
            now_[i] = part < 1 ? Vec3(from_[i] + part * (to_[i] - from_[i])) : to_[i];
    }

    [[nodiscard]] bool passes_while_changing(const Vec3& from, const Vec3& to) const
    {
        for (const TriangleCorners& corners : mesh_.triangles()) {
            const Triangle before = triangle(before_, corners);
            const Triangle now = triangle(now_, corners);
            Box box = bounding_box(before);
            for (const Vec3& corner : now.vertices) box.extend(corner);
            if (!is_beside(box, from, to) && Crossing(before, now, from, to).happens()) return true;
        }
        return false;
    }

    [[nodiscard]] bool passes_at_rest(std::span<const Vec3> path) const
    {
        for (const TriangleCorners& corners : mesh_.triangles()) {
            const Triangle now = triangle(now_, corners);
            const Box box = bounding_box(now);
            for (std::size_t i = 1; i < path.size(); ++i) {
                if (is_beside(box, path[i - 1], path[i])) continue;
                if (segment_meets_triangle(path[i - 1], path[i], now)) return true;
            }
        }
        return false;
    }

    [[nodiscard]] double distance(const Vec3& p) const
    {
        double least = std::numeric_limits<double>::infinity();
        for (const TriangleCorners& corners : mesh_.triangles()) {
            const Triangle now = triangle(now_, corners);
            const Box box = bounding_box(now);
            const Vec3 gap = (box.lower - p).cwiseMax(p - box.upper).cwiseMax(0.0);
            if (gap.norm() >= least) continue;
            least = std::min(least, (closest_point(now, p).point - p).norm());
        }
        return least;
    }

private:
    [[nodiscard]] static Triangle triangle(const std::vector<Vec3>& positions,
                                           const TriangleCorners& corners)
    {
        return {{positions[corners[0]], positions[corners[1]], positions[corners[2]]}};
    }

    const TriangleMesh& mesh_;
    std::vector<Vec3> before_;
    std::vector<Vec3> now_;
    std::vector<Vec3> from_;
    std::vector<Vec3> to_;
    std::vector<Vec3> given_;
    double seconds_ = 0;
    int ticks_ = 0;
};

enum class Script { rest, stroke, poke };

Vec3 hand_at(Script script, double depth, double seconds)
{
    constexpr double turn = 2 * std::numbers::pi;
    // It comes from above.
    const double down = 0.03 - (0.03 + depth) * std::min(seconds / 0.1, 1.0);
    switch (script) {
    case Script::rest:
        break;
    case Script::stroke:
        return {0.06 * std::sin(turn * 0.9 * seconds), 0.05 * std::cos(turn * 0.6 * seconds), down};
    case Script::poke:
        return {0.013, -0.007, down + depth * (1 - std::cos(turn * 3 * seconds))};
    }
    return {0.013, -0.007, down};
}

/// A position in the frame of the scene's first object at the begin and the end of the last tick.
Vec3 local_before(const TouchScene& scene, const Vec3& p)
{
    return to_local(moving_surface(scene).object(ObjectId{0}).before, p);
}
std::vector<Vec3> local_now(const TouchScene& scene, std::span<const Vec3> path)
{
    std::vector<Vec3> result;
    for (const Vec3& p : path)
        result.push_back(to_local(moving_surface(scene).object(ObjectId{0}).now, p));
    return result;
}

/// What is wrong with a tick in which the only object of a scene moved and changed; "" if nothing.
std::string problem_of(const TouchScene& scene, const HapticRenderer& renderer,
                       const Vertices& vertices, const Vec3& before)
{
    const RenderTick& felt = renderer.last();
    const std::span<const Vec3> carried = parts_of(renderer).carried_path();
    if (!felt.force.allFinite()) return "force";
    if (!carried.empty() && felt.is_placed) {
        const auto path = local_now(scene, carried);
        if (vertices.passes_while_changing(local_before(scene, before), path.front()))
            return "passed while it changed";
        if (vertices.passes_at_rest(path)) return "passed as it settled";
        if (renderer.path().front() != carried.back()) return "another path";
    }
    if (!felt.is_placed) return "";
    if (vertices.passes_at_rest(local_now(scene, renderer.path()))) return "passed at rest";
    const double distance = vertices.distance(local_now(scene, {&felt.proxy, 1}).front());
    const double gap = distance - parts_of(renderer).proxy().radius();
    return gap < -1e-12 ? "too near by " + std::to_string(-gap) : "";
}

struct Account {
    int touching = 0;
    int sticking = 0;
    double largest_lift = 0; ///< by which a proxy that sticks came away from the surface in a tick
    int squeezed = 0;
    double largest_step = 0;
    double largest = 0;
};

/// Touches a cloth for a second; everything is tested in every tick.
Account touch(const TriangleMesh& flat, const Wave& wave, Script script,
              const RenderOptions& options, const std::string& where)
{
    TouchScene scene(room);
    const TouchBody body = body_of(flat);
    const auto object = scene.add(body, {});
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), options).value();
    Vertices vertices(flat);
    Account account;
    Vec3 before = Vec3::Zero();
    Vec3 force = Vec3::Zero();
    double gap = 0;
    bool stuck = false;
    int frame = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const double seconds = tick * tick_seconds;
        if (seconds >= frame * frame_seconds) {
            ++frame;
            const auto positions = wave.positions(flat, frame * frame_seconds);
            const auto bent = refit_touch_body(body, positions);
            EXPECT_TRUE(bent && scene.deform(*object, *bent, frame_seconds)) << where;
            vertices.deform(positions, frame_seconds);
        }
        vertices.advance();
        const Vec3 hand = hand_at(script, wave.height, seconds);
        const std::size_t allocations = allocation_count();
        const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
        EXPECT_EQ(allocation_count(), allocations);
        const std::string problem = problem_of(scene, renderer, vertices, before);
        if (!problem.empty()) {
            ADD_FAILURE() << where << ", tick " << tick << ": " << problem;
            return account;
        }
        before = felt.proxy;
        if (felt.hold == Hold::sticking) {
            const double now = vertices.distance(felt.proxy) - parts_of(renderer).proxy().radius();
            if (stuck) account.largest_lift = std::max(account.largest_lift, now - gap);
            gap = now;
            ++account.sticking;
        }
        stuck = felt.hold == Hold::sticking;
        account.squeezed += felt.squeezed ? 1 : 0;
        account.touching += felt.hold != Hold::free ? 1 : 0;
        if (seconds > 0.15)
            account.largest_step = std::max(account.largest_step, (felt.force - force).norm());
        account.largest = std::max(account.largest, felt.force.norm());
        force = felt.force;
    }
    return account;
}

TEST(DeformingSurface, AWaveOfTwentyThousandTrianglesPassesNothing)
{
    const TriangleMesh flat = flat_cloth(100);
    ASSERT_EQ(flat.triangle_count(), 20000U);
    for (const std::uint32_t seed : {1U, 2U}) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi);
        for (const Script script : {Script::rest, Script::stroke, Script::poke}) {
            const bool even = seed % 2 == 0;
            const Wave wave = {even ? 0.01 : 0.005, even ? 4.0 : 2.0, 0.08, phase(random),
                               phase(random)};
            const RenderOptions options = plain(even ? 0.4 : 0, even ? 0.003 : 0);
            const std::string where = "seed " + std::to_string(seed) + ", script " +
                                      std::to_string(static_cast<int>(script));
            const Account account = touch(flat, wave, script, options, where);
            EXPECT_EQ(account.squeezed, 0) << where;
            EXPECT_GT(account.touching, 300) << where;
            // It is pressed in to twice the height of the wave, and never goes down on the far side.
            EXPECT_GT(account.largest, 500 * 1.5 * wave.height) << where;
            // The gentle wave turns the force by less than a facet of it a tick; nothing fades.
            if (!even) {
                EXPECT_LT(account.largest_step, 0.1 * account.largest) << where;
            }
            // Planes of triangles that turn lift it by up to 0.05 mm, and it goes down again.
            EXPECT_EQ(account.sticking > 30, even) << where;
            EXPECT_LT(account.largest_lift, 1e-9) << where;
            if (HasFailure()) return;
        }
    }
}

/// A shape of a mesh with a little noise, or a lot.
std::vector<Vec3> shaken(const TriangleMesh& mesh, std::mt19937& random, double size)
{
    std::uniform_real_distribution<double> number(-size, size);
    std::vector<Vec3> result(mesh.positions().begin(), mesh.positions().end());
    const Vec3 push(number(random), number(random), number(random));
    for (Vec3& p : result) p += push + 0.3 * Vec3(number(random), number(random), number(random));
    return result;
}

// Shapes at any time, of any duration, some of which never are begun, of objects that move as well.
TEST(DeformingSurface, NothingPassesWhateverShapesAreGiven)
{
    const std::vector<std::string> names = {"icosphere:2", "torus:16x8", "cube"};
    int touching = 0;
    int squeezed = 0;
    int ticks = 0;
    for (const std::uint32_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> number(-1, 1);
        const TriangleMesh mesh = moved(*sample_mesh(names[seed % names.size()]),
                                        [](const Vec3& p) { return Vec3(0.1 * p); });
        TouchScene scene(room);
        const TouchBody body = body_of(mesh);
        const auto object = scene.add(body, {});
        RenderOptions options = plain(seed % 2 == 0 ? 0.5 : 0, seed % 4 < 2 ? 0 : 0.004);
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), options).value();
        Vertices vertices(mesh);
        HandPath path(mesh, seed);
        Vec3 before = Vec3::Zero();
        for (int tick = 0; tick < 1500; ++tick) {
            while (random() % 8 == 0) {
                const double size = random() % 5 == 0 ? 0.03 : 0.003;
                const auto positions = shaken(mesh, random, size);
                const double seconds = random() % 4 == 0 ? 0.0 : 0.02 * std::abs(number(random));
                const auto bent = refit_touch_body(body, positions);
                ASSERT_TRUE(bent && scene.deform(*object, *bent, seconds));
                vertices.deform(positions, seconds);
            }
            if (random() % 40 == 0) {
                const Vec3 axis{number(random), number(random), number(random)};
                const Vec3 to{number(random), number(random), number(random)};
                ASSERT_TRUE(
                    scene.move(*object, {.pose = posed(0.1 * number(random), axis, 0.02 * to),
                                         .seconds = 0.05 * std::abs(number(random))}));
            }
            vertices.advance();
            const RenderTick& felt = renderer.tick(at(path.next()), tick_seconds);
            const std::string problem = problem_of(scene, renderer, vertices, before);
            ASSERT_EQ(problem, "") << "seed " << seed << ", tick " << tick;
            before = felt.proxy;
            touching += felt.hold != Hold::free ? 1 : 0;
            squeezed += felt.squeezed ? 1 : 0;
            ++ticks;
        }
    }
    std::printf("%d ticks, %d of touch, %d squeezed\n", ticks, touching, squeezed);
    EXPECT_GT(touching, ticks / 4);
    EXPECT_LT(squeezed, ticks / 100);
}

// A cloth that comes at a hand at rest, and goes beyond it: slowly, in one tick, and by way of shapes
// of which the servo loop sees the last alone.
TEST(DeformingSurface, AClothThatComesAtTheHandTakesTheProxyAlong)
{
    const TriangleMesh flat = flat_cloth(20);
    const auto at_height = [&](double z) {
        std::vector<Vec3> positions(flat.positions().begin(), flat.positions().end());
        for (Vec3& p : positions) p.z() += z;
        return positions;
    };
    const Vec3 hand(0.0123, 0.0071, 0.02);
    struct Given {
        std::vector<double> heights;
        double seconds;
    };
    const std::vector<Given> all = {
        {{0.03}, 0.1}, {{0.03}, 0.002}, {{0.03}, 0}, {{0.03, 0.0301}, 0}, {{-0.2, 0.4, 0.03}, 0}};
    for (const double radius : {0.0, 0.002}) {
        for (const Given& given : all) {
            const std::string where = std::to_string(given.heights.size()) + " shapes, " +
                                      std::to_string(given.seconds) + " s, radius " +
                                      std::to_string(radius);
            TouchScene scene(room);
            const TouchBody body = body_of(flat);
            const auto object = scene.add(body, {});
            HapticRenderer renderer =
                make_haptic_renderer(scene, same_unit, strong_device(), plain(0, radius)).value();
            Vertices vertices(flat);
            Vec3 before = hand;
            for (int tick = 0; tick < 200; ++tick) {
                if (tick == 20) {
                    for (const double z : given.heights) {
                        const auto bent = refit_touch_body(body, at_height(z));
                        ASSERT_TRUE(bent && scene.deform(*object, *bent, given.seconds));
                        vertices.deform(at_height(z), given.seconds);
                    }
                }
                vertices.advance();
                const RenderTick& felt = renderer.tick(at(hand), tick_seconds);
                ASSERT_EQ(problem_of(scene, renderer, vertices, before), "")
                    << where << ' ' << tick;
                ASSERT_FALSE(felt.squeezed) << where;
                before = felt.proxy;
            }
            const double depth = given.heights.back() + radius - hand.z();
            EXPECT_NEAR(renderer.last().spring.z(), 500 * depth, 1e-5) << where;
        }
    }
}

// The tree gives the proxy and the force the bits that testing every triangle gives them.
TEST(DeformingSurface, HasTheBitsOfEveryTriangle)
{
    const TriangleMesh flat = flat_cloth(16);
    const Wave wave = {0.01, 3, 0.1, 0.3, 0.4};
    for (const double radius : {0.0, 0.002}) {
        RenderOptions options = plain(0.3, radius);
        options.shading = ForceShading::on;
        TouchScene scene(room);
        TouchScene slow(room);
        const TouchBodyOptions shaded = {.material = {}, .shading = ForceShading::on};
        const TouchBody body = body_of(flat, shaded);
        const TouchBody every = body_of(flat, shaded, BodySearch::every_triangle);
        const auto object = scene.add(body, {});
        const auto same = slow.add(every, {});
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), options).value();
        HapticRenderer expected =
            make_haptic_renderer(slow, same_unit, strong_device(), options).value();
        int touching = 0;
        for (int tick = 0; tick < 800; ++tick) {
            if (tick % 17 == 0) {
                const auto positions = wave.positions(flat, (tick + 17) * tick_seconds);
                ASSERT_TRUE(scene.deform(*object, *refit_touch_body(body, positions), 0.0167));
                ASSERT_TRUE(slow.deform(*same, *refit_touch_body(every, positions), 0.0167));
            }
            const Vec3 hand = hand_at(Script::stroke, 0.01, tick * tick_seconds);
            const RenderTick& is = renderer.tick(at(hand), tick_seconds);
            const RenderTick& should = expected.tick(at(hand), tick_seconds);
            ASSERT_EQ(is.force, should.force) << radius << ' ' << tick;
            ASSERT_EQ(is.proxy, should.proxy) << radius << ' ' << tick;
            touching += is.hold != Hold::free ? 1 : 0;
        }
        EXPECT_GT(touching, 500);
    }
}

// A cloth whose vertices all move alike is a plate that moves.
TEST(DeformingSurface, FeelsLikeAnObjectThatMovesAsItsVerticesDo)
{
    const TriangleMesh flat = flat_cloth(30);
    TouchScene changing(room);
    TouchScene moving(room);
    const TouchBody body = body_of(flat);
    const auto cloth = changing.add(body, {});
    const auto plate = moving.add(body, {});
    RenderOptions options = plain(0.4, 0);
    options.force.damping = 2;
    HapticRenderer renderer =
        make_haptic_renderer(changing, same_unit, strong_device(), options).value();
    HapticRenderer expected =
        make_haptic_renderer(moving, same_unit, strong_device(), options).value();
    const Vec3 hand(0.0123, 0.0071, -0.003);
    for (TouchScene* const scene : {&changing, &moving}) {
        HapticRenderer& of = scene == &changing ? renderer : expected;
        of.tick(at(Vec3(0.0123, 0.0071, 0.01)), tick_seconds);
    }
    int sticking = 0;
    for (int tick = 0; tick < 600; ++tick) {
        if (tick % 20 == 0) {
            const double t = 0.001 * (tick + 20);
            const Vec3 to(0.004 * std::sin(9 * t), 0.002 * std::sin(5 * t),
                          0.002 * std::sin(12 * t));
            std::vector<Vec3> positions(flat.positions().begin(), flat.positions().end());
            for (Vec3& p : positions) p += to;
            ASSERT_TRUE(changing.deform(*cloth, *refit_touch_body(body, positions), 0.02));
            ASSERT_TRUE(moving.move(*plate, {.pose = at_place(to), .seconds = 0.02}));
        }
        const RenderTick& is = renderer.tick(at(hand), tick_seconds);
        const RenderTick& should = expected.tick(at(hand), tick_seconds);
        ASSERT_EQ(is.hold, should.hold) << tick;
        ASSERT_LT((is.force - should.force).norm(), 1e-5) << tick;
        ASSERT_LT((is.surface_velocity - should.surface_velocity).norm(), 1e-9) << tick;
        sticking += is.hold == Hold::sticking ? 1 : 0;
    }
    EXPECT_GT(sticking, 20);
    EXPECT_LT(sticking, 590);
}

TEST(DeformingSurface, RefusesWhatIsNoShapeOfTheObject)
{
    TouchScene scene(room);
    const TriangleMesh flat = flat_cloth(4);
    const TouchBody body = body_of(flat);
    const auto object = scene.add(body, {});
    std::vector<Vec3> positions(flat.positions().begin(), flat.positions().end());
    const auto refit = refit_touch_body(body, positions);
    ASSERT_TRUE(refit);
    // A body with equal triangles that was built on its own is no refit.
    EXPECT_EQ(scene.deform(*object, body_of(flat), 0.01).error().code, ErrorCode::invalid_argument);
    EXPECT_FALSE(scene.deform(*object, *refit, -1));
    EXPECT_FALSE(scene.deform(*object, *refit, std::nan("")));
    EXPECT_TRUE(scene.deform(*object, *refit, 0.01));
    // A refit of a refit, and back to the first.
    EXPECT_TRUE(scene.deform(*object, *refit_touch_body(*refit, positions), 0.01));
    EXPECT_TRUE(scene.deform(*object, body, 0.01));
    positions[0] = Vec3(2, 0, 0);
    EXPECT_NE(scene.deform(*object, *refit_touch_body(body, positions), 0.01)
                  .error()
                  .message.find("bounds"),
              std::string::npos);
    positions[0].x() = std::nan("");
    EXPECT_EQ(refit_touch_body(body, positions).error().code, ErrorCode::invalid_mesh);
    positions.pop_back();
    const auto few = refit_touch_body(body, positions);
    ASSERT_FALSE(few);
    EXPECT_NE(few.error().message.find("has 24 positions, and its body has 25 vertices"),
              std::string::npos);
}

// A refit is a body of its own, too: what was built from the same positions gives the same bits.
TEST(DeformingSurface, ARefitIsABodyOfItsOwn)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return 0.1 * p; });
    const auto stretched = [](const Vec3& p) { return Vec3(0.8 * p.x(), 1.3 * p.y(), p.z()); };
    std::vector<Vec3> positions;
    for (const Vec3& p : ball.positions()) positions.push_back(stretched(p));
    const TouchBody refit = *refit_touch_body(body_of(ball), positions);
    const TouchBody built = body_of(moved(ball, stretched));
    for (const double radius : {0.0, 0.003}) {
        TouchScene scene(room);
        TouchScene same(room);
        ASSERT_TRUE(scene.add(refit, {}));
        ASSERT_TRUE(same.add(built, {}));
        HapticRenderer renderer =
            make_haptic_renderer(scene, same_unit, strong_device(), plain(0.3, radius)).value();
        HapticRenderer expected =
            make_haptic_renderer(same, same_unit, strong_device(), plain(0.3, radius)).value();
        HandPath path(refit.mesh(), 4);
        int touching = 0;
        renderer.tick(at(Vec3(0.3, 0, 0)), tick_seconds); // it starts outside
        expected.tick(at(Vec3(0.3, 0, 0)), tick_seconds);
        for (int tick = 0; tick < 600; ++tick) {
            const Vec3 hand = path.next();
            ASSERT_EQ(renderer.tick(at(hand), tick_seconds).force,
                      expected.tick(at(hand), tick_seconds).force)
                << radius << ' ' << tick;
            touching += renderer.last().hold != Hold::free ? 1 : 0;
        }
        EXPECT_GT(touching, 150);
    }
}

TEST(DeformingSurface, AnotherThreadMayGiveShapes)
{
    const TriangleMesh ball =
        moved(*sample_mesh("icosphere:3"), [](const Vec3& p) { return 0.1 * p; });
    TouchScene scene(room);
    const TouchBody body = body_of(ball);
    const auto object = scene.add(body, {});
    HapticRenderer renderer =
        make_haptic_renderer(scene, same_unit, strong_device(), plain(0.3, 0)).value();
    std::atomic<bool> ended{false};
    std::atomic<int> shapes{0};
    std::thread application([&] {
        for (int frame = 0; !ended.load(); ++frame) {
            std::vector<Vec3> positions;
            for (const Vec3& p : ball.positions())
                positions.push_back(p * (1 + 0.03 * std::sin(frame)));
            EXPECT_TRUE(scene.deform(*object, *refit_touch_body(body, positions), 0.002));
            if (frame % 50 == 49) {
                EXPECT_TRUE(scene.exchange(*object, body));
            }
            ++shapes;
            std::this_thread::sleep_for(std::chrono::microseconds(700));
        }
    });
    int touching = 0;
    const ServoStatistics seen = run_servo_loop({.ticks = 400}, [&](std::uint64_t tick) noexcept {
        const double down = 0.0002 * static_cast<double>(std::min<std::uint64_t>(tick, 100));
        const RenderTick& felt = renderer.tick(at(Vec3(0.01, 0.02, 0.11 - down)), tick_seconds);
        touching += felt.hold != Hold::free ? 1 : 0;
        return felt.force.allFinite() ? Flow::proceed : Flow::stop;
    });
    ended.store(true);
    application.join();
    EXPECT_EQ(seen.ticks, 400U);
    EXPECT_GT(touching, 100);
    EXPECT_GT(shapes.load(), 0);
}

} // namespace
} // namespace proxima
