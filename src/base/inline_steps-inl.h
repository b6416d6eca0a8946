// How much of a kernel is copied into its callers. Included once per target, after <hwy/highway.h>.
//
//     PROXIMA_LANE_OP   an operation on lanes: copied, but where eight lanes are eight numbers
//     PROXIMA_STEP      a step of a query: copied, but on x86 processors older than AVX2 (2013)
//
// Kernels are compiled for these as well and seldom run there: calls keep their code small, which
// halves what a build takes.

#undef PROXIMA_LANE_OP
#undef PROXIMA_STEP

#if HWY_TARGET == HWY_SCALAR
#define PROXIMA_LANE_OP HWY_NOINLINE inline
#else
#define PROXIMA_LANE_OP HWY_INLINE
#endif

#if HWY_ARCH_X86 && HWY_TARGET > HWY_AVX2
#define PROXIMA_STEP HWY_NOINLINE inline
#else
#define PROXIMA_STEP HWY_INLINE
#endif
