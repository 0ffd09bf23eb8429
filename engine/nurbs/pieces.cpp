#include "engine/nurbs/pieces.hpp"

namespace pantin::detail::nurbs {

void to_powers(std::span<Weighted> piece) {
  const std::size_t p = piece.size() - 1;
  std::vector<Weighted> differences(piece.begin(), piece.end()), work;
  Real factor = 1;
  for (std::size_t k = 0; k <= p; ++k) {
    work = differences;
    for (std::size_t r = p - k; r > 0; --r)
      for (std::size_t i = 0; i < r; ++i) work[i] = 0.5 * (work[i] + work[i + 1]);
    piece[k] = factor * work[0];
    factor = factor * static_cast<Real>(p - k) / static_cast<Real>(k + 1);
    for (std::size_t i = 0; i + 1 < differences.size(); ++i)
      differences[i] = differences[i + 1] - differences[i];
    differences.pop_back();
  }
}

}  // namespace pantin::detail::nurbs
