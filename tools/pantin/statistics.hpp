#pragma once
/// Ranks of samples.
#include <algorithm>
#include <cmath>
#include <vector>

namespace pantin::program {

/// The sample that a part `p` (0..1) of all samples does not exceed (nearest rank); 0 of none.
/// Reorders the samples.
inline double quantile(std::vector<double>& samples, double p) {
  if (samples.empty()) return 0;
  const auto count = static_cast<double>(samples.size());
  const auto rank = static_cast<std::size_t>(std::clamp(std::ceil(p * count) - 1, 0.0, count - 1));
  const auto at = samples.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(samples.begin(), at, samples.end());
  return *at;
}

struct Ranks {
  double median = 0, p95 = 0, p99 = 0, most = 0;
};

inline Ranks ranks_of(std::vector<double> samples) {
  return {quantile(samples, 0.5), quantile(samples, 0.95), quantile(samples, 0.99),
          quantile(samples, 1)};
}

}  // namespace pantin::program
