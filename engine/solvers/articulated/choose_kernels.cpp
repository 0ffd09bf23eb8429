#include <cstdlib>
#include <cstring>

#include "engine/base/check.hpp"
#include "engine/base/compiler.hpp"
#include "engine/solvers/articulated/kernels.hpp"

namespace pantin::detail::articulated {

extern const Kernels kernels_baseline;
#ifdef PANTIN_HAS_AVX2
extern const Kernels kernels_avx2;
#endif
#ifdef PANTIN_HAS_AVX512
extern const Kernels kernels_avx512;
#endif

const Kernels* const* all_kernels() {
  static const Kernels* const kBaselineOnly[] = {&kernels_baseline, nullptr};
#ifdef PANTIN_HAS_AVX512
  static const Kernels* const kAll[] = {&kernels_baseline, &kernels_avx2, &kernels_avx512, nullptr};
  if (PANTIN_CPU_HAS_AVX512()) return kAll;
#endif
#ifdef PANTIN_HAS_AVX2
  static const Kernels* const kBoth[] = {&kernels_baseline, &kernels_avx2, nullptr};
  if (PANTIN_CPU_HAS_AVX2()) return kBoth;
#endif
  return kBaselineOnly;
}

namespace {

const Kernels& choose() {
  const Kernels* best = nullptr;
  const char* bias = std::getenv("PANTIN_KERNELS");
  for (const Kernels* const* k = all_kernels(); *k; ++k) {
    best = *k;
    if (bias && std::strcmp(bias, (*k)->name) == 0) break;
  }
  PANTIN_ASSERT(best);
  return *best;
}

}  // namespace

const Kernels& kernels() {
  static const Kernels& kChosen = choose();
  return kChosen;
}

}  // namespace pantin::detail::articulated
