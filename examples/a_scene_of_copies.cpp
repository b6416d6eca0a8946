#include <iostream>
#include <proxima/proxima.h>
#include <vector>

int main()
{
    using namespace proxima;
    const auto ball = sample_mesh("icosphere:3").and_then([](const TriangleMesh& mesh) {
        return build_mesh_index(mesh);
    });
    if (!ball) return std::cerr << describe(ball.error()) << '\n', 1;

    // Ten thousand balls of one index, 2.5 apart in a square, but for one that has rolled away.
    std::vector<Instance> instances;
    for (int i = 0; i < 10000; ++i)
        instances.push_back({.pose = {.translation = {2.5 * (i % 100), 2.5 * (i / 100), 0}}});
    instances[5050].pose.translation.x() += 1;
    const auto scene = build_scene(std::vector{*ball}, instances);
    if (!scene) return std::cerr << describe(scene.error()) << '\n', 1;

    if (const auto hit = closest_hit(*scene, {.origin = {-5, 0, 0.5}, .direction = {1, 0, 0}}))
        std::cout << "the ray hits ball " << to_index(hit->instance) << '\n';
    if (const auto near = closest_feature(*scene, {100, 100, 5}))
        std::cout << "ball " << to_index(near->instance) << " is " << near->distance << " away\n";
    if (const auto pairs = pairs_in_contact(*scene))
        for (const auto& [a, b] : *pairs)
            std::cout << "balls " << to_index(a) << " and " << to_index(b) << " touch\n";
}
