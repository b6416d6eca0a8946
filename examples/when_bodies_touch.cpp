#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    const auto cube = sample_mesh("cube").and_then(
        [](const TriangleMesh& mesh) { return build_mesh_index(mesh); });
    if (!cube) return std::cerr << describe(cube.error()) << '\n', 1;

    // A cube of side 2 flies at another one and turns by a quarter on the way.
    const RigidMotion flight{.start = {.translation = {5, 0, 0}},
                             .displacement = {-4, 0, 0},
                             .turn = {0, 0, 1.5707963267948966}};
    if (const auto contact = time_of_contact(*cube, *cube, flight))
        std::cout << "touches at " << contact->touches_at << " of its way, at "
                  << contact->point_a.x() << ' ' << contact->point_a.y() << '\n';

    // At the end they overlap. How far must it move, and where to, to be free again?
    const auto solid = build_solid(*cube);
    if (!solid) return std::cerr << describe(solid.error()) << '\n', 1;
    const auto depth = penetration_depth(*solid, *solid, pose_at(flight, 1));
    if (!depth) return std::cerr << describe(depth.error()) << '\n', 1;
    std::cout << "overlaps by " << depth->upper << ", free along " << depth->direction.x() << '\n';
}
