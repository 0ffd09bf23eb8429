#pragma once
/// All compiler extensions in use. Everything else is standard C++20, so a new compiler needs
/// changes in this file only. Without extensions the plain forms below give the same bits, but
/// slower (PANTIN_PLAIN_CPP selects them). Vectors are in lanes.hpp.

#if defined(__GNUC__) && !defined(PANTIN_PLAIN_CPP)
#define PANTIN_INLINE inline __attribute__((always_inline))
#elif defined(_MSC_VER)
#define PANTIN_INLINE __forceinline
#else
#define PANTIN_INLINE inline
#endif

#ifdef __GNUC__
/// Vectors wider than the baseline's registers are passed between inlined functions only.
#define PANTIN_QUIET_VECTORS _Pragma("GCC diagnostic ignored \"-Wpsabi\"")
/// For third-party headers that do not compile without warnings.
#define PANTIN_QUIET_BEGIN                                                          \
  _Pragma("GCC diagnostic push") _Pragma("GCC diagnostic ignored \"-Wconversion\"") \
      _Pragma("GCC diagnostic ignored \"-Wunused-function\"")                       \
          _Pragma("GCC diagnostic ignored \"-Wunused-parameter\"")
#define PANTIN_QUIET_END _Pragma("GCC diagnostic pop")
#else
#define PANTIN_QUIET_VECTORS
#define PANTIN_QUIET_BEGIN
#define PANTIN_QUIET_END
#endif

// The compiler, for the headers of measurements.
#if defined(__clang__)
#define PANTIN_COMPILER "clang " __clang_version__
#elif defined(__GNUC__)
#define PANTIN_COMPILER "gcc " __VERSION__
#else
#define PANTIN_COMPILER "unknown"
#endif

// Whether this processor has AVX2, or AVX-512; called only if kernels for it are built.
#ifdef __GNUC__
#define PANTIN_CPU_HAS_AVX2() __builtin_cpu_supports("avx2")
#define PANTIN_CPU_HAS_AVX512()                                               \
  (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && \
   __builtin_cpu_supports("avx512dq"))
#else
#define PANTIN_CPU_HAS_AVX2() false
#define PANTIN_CPU_HAS_AVX512() false
#endif
