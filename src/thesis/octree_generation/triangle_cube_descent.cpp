#include "thesis/octree_generation/triangle_cube_descent.h"

namespace proxima {

template class TriangleCubeDescent<double>;
template class TriangleCubeDescent<std::int64_t>;

} // namespace proxima
