#include "engine/assembly/descent.hpp"
#include "engine/assembly/methods/comparison.hpp"

namespace pantin::detail::assembly {

std::span<const Method> methods() {
  static constexpr Method kMethods[] = {
      {"auto", "Levenberg-Marquardt, Gauss-Newton near the end", &descend_auto, true},
      {"gauss-newton", "Gauss-Newton, rotations of at most 1 rad a step", &descend_gauss_newton,
       true},
      {"lm", "Levenberg-Marquardt, monotone", &descend_levenberg, true},
      {"gradient", "gradient descent in quaternions, k = 0.1", &descend_gradient},
      {"gradient-safe", "the same with k from a bound of the eigenvalues",
       &descend_gradient_safely},
      {"momentum", "the gradient with momentum", &descend_momentum},
      {"gauss-seidel", "one law after the other", &descend_gauss_seidel},
      {"euler-angles", "gradient descent in Euler angles", &descend_euler_angles},
  };
  return kMethods;
}

}  // namespace pantin::detail::assembly
