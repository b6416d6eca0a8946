#include <iostream>
#include <proxima/proxima.h>

int main()
{
    using namespace proxima;
    // A ball, and a coarse copy of it: how far is one surface from the other, at most and on average?
    const auto index_of = [](const char* name) {
        return sample_mesh(name).and_then(
            [](const TriangleMesh& mesh) { return build_mesh_index(mesh); });
    };
    const auto fine = index_of("icosphere:5");
    const auto coarse = index_of("icosphere:2");
    if (!fine || !coarse) return std::cerr << "no such mesh\n", 1;
    const auto there = greatest_deviation(*fine, *coarse);
    const auto back = greatest_deviation(*coarse, *fine);
    const auto mean = mean_deviation(*fine, *coarse);
    if (!there || !back || !mean) return std::cerr << "no answer\n", 1;
    const DistanceBounds hausdorff = both_ways(there->distance, back->distance);
    std::cout << "Hausdorff distance from " << hausdorff.lower << " to " << hausdorff.upper
              << "\nmean distance from " << mean->mean.lower << " to " << mean->mean.upper
              << "\nfarthest at " << there->point_a.transpose() << '\n';
}
