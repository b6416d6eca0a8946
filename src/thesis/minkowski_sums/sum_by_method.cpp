#include "proxima/thesis.h"

#include "minkowski/operation_counts.h"
#include "minkowski/sum_by_arcs.h"
#include "thesis/minkowski_sums/count_sum_by_method.h"
#include "thesis/minkowski_sums/sum_baselines.h"

#include <utility>

namespace proxima {

namespace {

template <class Scalar>
Result<MinkowskiSum> sum_on(MinkowskiMethod method, const ConvexPolyhedron& a,
                            const ConvexPolyhedron& b, Progress* progress)
{
    switch (method) {
    case MinkowskiMethod::geometric:
        return detail::sum_by_geometric_method<Scalar>(a, b, progress);
    case MinkowskiMethod::hull:
        return detail::sum_by_hull<Scalar>(a, b, progress);
    case MinkowskiMethod::arcs:
        break;
    }
    return detail::sum_by_arcs<Scalar>(a, b, progress);
}

} // namespace

Result<MinkowskiSum> minkowski_sum_by(MinkowskiMethod method, const ConvexPolyhedron& a,
                                      const ConvexPolyhedron& b, const MinkowskiOptions& options)
{
    return sum_on<double>(method, a, b, options.execution.progress);
}

Result<CountedSum> count_minkowski_sum(MinkowskiMethod method, const ConvexPolyhedron& a,
                                       const ConvexPolyhedron& b, Progress* progress)
{
    reset_operation_counts();
    auto sum = sum_on<Counted>(method, a, b, progress);
    if (!sum) return tl::unexpected(sum.error());
    return CountedSum{std::move(*sum), operation_counts()};
}

} // namespace proxima
