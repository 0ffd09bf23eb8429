#include "engine/assembly/descent.hpp"

namespace pantin::detail::assembly {

std::span<const Method> methods() {
  static constexpr Method kMethods[] = {
      {"auto", "Levenberg-Marquardt, Gauss-Newton near the end", &descend_auto},
      {"gauss-newton", "Gauss-Newton with rotations of at most 0.5 rad a step",
       &descend_gauss_newton},
      {"lm", "Levenberg-Marquardt to the end", &descend_levenberg},
  };
  return kMethods;
}

}  // namespace pantin::detail::assembly
