// Uses one function of each kind from the installed package: header-only, compiled, parallel.
#include "proxima/base/parallel.h"
#include "proxima/mesh/triangle_mesh.h"
#include "proxima/octree/cell.h"

#include <iostream>

int main()
{
    const auto mesh = proxima::make_triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    if (!mesh) {
        std::cerr << proxima::describe(mesh.error()) << '\n';
        return 1;
    }
    int calls = 0;
    proxima::parallel_for(3, {1}, [&](std::size_t) { ++calls; });
    const proxima::CellKey key = proxima::cell_key({1, 2, 3}, 2);
    std::cout << mesh->triangle_count() << ' ' << calls << ' ' << proxima::depth(key) << '\n';
    return 0;
}
