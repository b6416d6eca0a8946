// Scenes whose instances cannot be moved: they stay as they were.
#include "code_of.h"
#include "counted_allocations.h"
#include "proxima/scene.h"
#include "query/scene/scenes_one_by_one.h"

#include <gtest/gtest.h>
#include <new>
#include <optional>
#include <vector>

namespace proxima::move_scene_test {
namespace {

using namespace testing;

TEST(Scene, IsAsItWasAfterAMoveThatWasRefused)
{
    const RandomScene of = many_instances(100, 3);
    Scene scene = build_scene(of.shapes, of.instances).value();
    const RigidTransform good = of.instances[7].pose;
    RigidTransform bent = good;
    bent.rotation(0, 0) += 1;
    RigidTransform far = good;
    far.translation.x() = 1e200;
    const auto refused = [&](const std::vector<InstanceId>& ids,
                             const std::vector<RigidTransform>& poses, const std::string& words) {
        const Status status = move_in_place(scene, ids, poses);
        ASSERT_FALSE(status) << words;
        EXPECT_EQ(code_of(status), ErrorCode::invalid_argument);
        EXPECT_NE(describe(status.error()).find(words), std::string::npos)
            << describe(status.error());
    };
    refused({id_of(1), id_of(2)}, {good}, "a list of 1 poses, but 2 instances");
    refused({id_of(1), id_of(100)}, {good, good}, "instance 100");
    refused({id_of(1), id_of(2)}, {good, bent}, "instance 2");
    refused({id_of(1), id_of(3)}, {good, far}, "instance 3");
    refused({id_of(1), id_of(1)}, {bent, good}, "instance 1"); // though the last pose counts
    refused(
        std::vector<InstanceId>(20, id_of(2)), // and all boxes are drawn again
        [&] {
            std::vector<RigidTransform> poses(20, good);
            poses.front() = bent;
            return poses;
        }(),
        "instance 2");
    const std::vector<InstanceId> half(50, id_of(4));
    refused(half, std::vector<RigidTransform>(50, bent), "instance 4");
    for (std::size_t i = 0; i < of.instances.size(); ++i)
        EXPECT_EQ(scene.instance(id_of(i)).pose.translation, of.instances[i].pose.translation);
    EXPECT_TRUE(move_in_place(scene, {}, std::span<const RigidTransform>()));
    Scene none;
    EXPECT_TRUE(move_in_place(none, {}, std::span<const RigidTransform>()));
}

TEST(Scene, IsAsItWasAfterAMoveThatWasStopped)
{
    // Enough instances that a move of some in place reports more than once.
    const RandomScene of = many_instances(20000, 8);
    Scene scene = build_scene(of.shapes, of.instances).value();
    std::vector<InstanceId> ids;
    std::vector<RigidTransform> poses;
    for (std::size_t i = 0; i < 2000; ++i) {
        ids.push_back(id_of(i));
        poses.push_back(of.instances[i + 1].pose);
    }
    for (const std::uint64_t reports : {0, 1, 2}) { // before the move, at its beginning, amid it
        Progress progress;
        if (reports == 0) {
            progress.cancel();
        } else {
            progress.cancel_after(reports);
        }
        const Status status =
            move_in_place(scene, ids, poses, {.execution = {.progress = &progress}});
        ASSERT_FALSE(status) << reports;
        EXPECT_EQ(code_of(status), ErrorCode::cancelled);
        for (std::size_t i = 0; i < of.instances.size(); ++i)
            ASSERT_EQ(scene.instance(id_of(i)).pose.translation, of.instances[i].pose.translation);
    }
    Progress watched;
    ASSERT_TRUE(move_in_place(scene, ids, poses, {.execution = {.progress = &watched}}));
    EXPECT_STREQ(watched.stage(), "placing instances"); // in place: no box was drawn again
}

/// What a scene says of rays and points, and of its instances.
struct Answers {
    std::vector<std::optional<SceneHit>> hits;
    std::vector<double> numbers;
    std::vector<InstancePair> pairs;
    friend bool operator==(const Answers&, const Answers&) = default;
};

class Questions {
public:
    Questions(const RandomScene& of, SceneGenerator& random)
    {
        SceneQueries query(of, random);
        for (int i = 0; i < 300; ++i) {
            rays_.push_back(query.ray());
            points_.push_back(query.place());
        }
    }

    [[nodiscard]] Answers ask(const Scene& scene) const
    {
        Answers answers;
        for (const Ray& ray : rays_) answers.hits.push_back(closest_hit(scene, ray));
        for (const Vec3& p : points_) {
            const auto found = closest_feature(scene, p);
            put(answers, {static_cast<double>(to_index(found->instance)), found->distance});
        }
        for (std::size_t i = 0; i < scene.instance_count(); ++i) {
            const RigidTransform pose = scene.instance(id_of(i)).pose;
            const Box box = scene.bounds(id_of(i));
            for (int k = 0; k < 3; ++k) {
                put(answers, {pose.translation[k], box.lower[k], box.upper[k]});
                for (int j = 0; j < 3; ++j) put(answers, {pose.rotation(j, k)});
            }
        }
        answers.pairs = pairs_in_contact(scene, {.execution = {.threads = {1}}}).value();
        return answers;
    }

private:
    static void put(Answers& answers, std::initializer_list<double> numbers)
    {
        answers.numbers.insert(answers.numbers.end(), numbers);
    }

    std::vector<Ray> rays_;
    std::vector<Vec3> points_;
};

/// Moves instances with each allocation failing in turn, then with none. How many failed.
std::size_t fail_each_allocation(Scene& scene, const std::vector<InstanceId>& ids,
                                 const std::vector<RigidTransform>& poses,
                                 const Questions& questions)
{
    const Answers before = questions.ask(scene);
    for (std::size_t failed = 0;; ++failed) {
        try {
            fail_allocation(failed + 1);
            const Status moved = move_in_place(scene, ids, poses, {{.threads = {1}}});
            fail_allocation(0);
            EXPECT_TRUE(moved);
            return failed;
        } catch (const std::bad_alloc&) {
            EXPECT_TRUE(questions.ask(scene) == before) << "without allocation " << failed + 1;
        }
    }
}

TEST(Scene, IsAsItWasWhereMemoryRanOutInAMove)
{
    constexpr std::uint64_t seed = 8;
    RandomScene of = many_instances(300, seed);
    SceneGenerator random(seed);
    const Questions questions(of, random);
    Scene scene = build_scene(of.shapes, of.instances).value();
    const auto move = [&](std::size_t count, double reach) {
        std::vector<InstanceId> ids;
        std::vector<RigidTransform> poses;
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t id = random.below(of.instances.size());
            of.instances[id].pose.translation = reach * of.size * random.vector();
            ids.push_back(id_of(id));
            poses.push_back(of.instances[id].pose);
        }
        const std::size_t failed = fail_each_allocation(scene, ids, poses, questions);
        EXPECT_TRUE(failed >= 3 || allocation_count() == 0) << failed; // or none is counted
        const Scene truth = build_scene(of.shapes, of.instances).value();
        EXPECT_TRUE(questions.ask(scene).hits == questions.ask(truth).hits);
    };
    const SceneParts* const first = &scene.parts();
    for (int step = 0; step < 4; ++step) move(20, 0.9);
    EXPECT_EQ(&scene.parts(), first);
    const Scene copy = scene;
    const Answers of_copy = questions.ask(copy);
    move(20, 0.9);
    EXPECT_NE(&scene.parts(), &copy.parts());
    move(20, 2); // beyond the box of all
    move(100, 0.9);
    EXPECT_TRUE(questions.ask(copy) == of_copy);
}

TEST(Scene, SharesItsArraysAfterAMoveOfNoInstances)
{
    const RandomScene of = many_instances(20, 4);
    Scene scene = build_scene(of.shapes, of.instances).value();
    const Scene copy = scene;
    ASSERT_TRUE(move_in_place(scene, {}, std::span<const RigidTransform>()));
    EXPECT_EQ(&scene.parts(), &copy.parts());
}

} // namespace
} // namespace proxima::move_scene_test
