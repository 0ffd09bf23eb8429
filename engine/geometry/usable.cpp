#include "engine/geometry/usable.hpp"

#include "engine/base/invariants.hpp"
#include "engine/geometry/kinds.hpp"

namespace pantin::detail {

bool is_usable(const Shape& shape) {
  if (!is_complete(shape) || !is_finite(shape.local) || !is_unit(shape.local)) return false;
  for (const SizeKey& key : traits_of(shape.kind).sizes)
    for (int k = key.first; k < key.first + key.count; ++k)
      if (!(shape.size[k] >= 0 && std::isfinite(shape.size[k]))) return false;
  return true;
}

}  // namespace pantin::detail
