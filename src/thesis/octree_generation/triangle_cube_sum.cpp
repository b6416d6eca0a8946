#include "thesis/octree_generation/triangle_cube_sum.h"

namespace proxima {

template class TriangleCubeSum<double>;
template class TriangleCubeSum<std::int64_t>;

} // namespace proxima
