// Reads the grid "distance" of a .vdb file, of so many points along x, y and z, by OpenVDB. Prints the
// grid's class, background and transform, then the value and state of each voxel, x fastest.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <openvdb/openvdb.h>

int main(int argc, char** argv)
try {
    if (argc != 5) return 2;
    openvdb::initialize();
    openvdb::io::File file(argv[1]);
    file.open();
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("distance"));
    file.close();
    const openvdb::Vec3d origin = grid->indexToWorld(openvdb::Vec3d(0, 0, 0));
    const openvdb::Vec3d next = grid->indexToWorld(openvdb::Vec3d(1, 1, 1));
    std::printf("%s %.9g\n%.17g %.17g %.17g\n%.17g %.17g %.17g\n",
                openvdb::GridBase::gridClassToString(grid->getGridClass()).c_str(),
                static_cast<double>(grid->background()), origin.x(), origin.y(), origin.z(),
                next.x() - origin.x(), next.y() - origin.y(), next.z() - origin.z());
    auto voxels = grid->getConstAccessor();
    for (int k = 0; k < std::atoi(argv[4]); ++k) {
        for (int j = 0; j < std::atoi(argv[3]); ++j) {
            for (int i = 0; i < std::atoi(argv[2]); ++i) {
                float value = 0;
                const bool active = voxels.probeValue({i, j, k}, value);
                std::printf("%.9g %d\n", static_cast<double>(value), active ? 1 : 0);
            }
        }
    }
    std::printf("%llu\n", static_cast<unsigned long long>(grid->activeVoxelCount()));
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
