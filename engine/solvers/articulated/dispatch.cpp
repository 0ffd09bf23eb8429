#include <cstdlib>
#include <cstring>

#include "engine/solvers/articulated/kernels.hpp"

namespace pantin::articulated {

extern const Kernels kernels_baseline;
#ifdef PANTIN_HAS_AVX2
extern const Kernels kernels_avx2;
#endif

const Kernels* const* all_kernels() {
  static const Kernels* const kBaselineOnly[] = {&kernels_baseline, nullptr};
#ifdef PANTIN_HAS_AVX2
  static const Kernels* const kBoth[] = {&kernels_baseline, &kernels_avx2, nullptr};
  if (__builtin_cpu_supports("avx2")) return kBoth;
#endif
  return kBaselineOnly;
}

namespace {

const Kernels& choose() {
  const Kernels* best = nullptr;
  const char* wanted = std::getenv("PANTIN_KERNELS");
  for (const Kernels* const* k = all_kernels(); *k; ++k) {
    best = *k;
    if (wanted && std::strcmp(wanted, (*k)->name) == 0) break;
  }
  return *best;
}

}  // namespace

const Kernels& kernels() {
  static const Kernels& kChosen = choose();
  return kChosen;
}

}  // namespace pantin::articulated
