#pragma once
/// Butcher tableaux of explicit Runge-Kutta methods.

namespace pantin::detail {

/// Nodes c, coefficients a, weights b; `lower`: weights of the embedded method of lower order.
struct ButcherTableau {
  int stages;
  double c[7], a[7][6], b[7], lower[7];
};

/// The classic method of order 4.
inline constexpr ButcherTableau kClassicRungeKutta{4,
                                                   {0, 0.5, 0.5, 1},
                                                   {{}, {0.5}, {0, 0.5}, {0, 0, 1}},
                                                   {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6},
                                                   {}};
/// The 5(4) pair. [Dormand & Prince 1980]
inline constexpr ButcherTableau kDormandPrince{
    7,
    {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1},
    {{},
     {1.0 / 5},
     {3.0 / 40, 9.0 / 40},
     {44.0 / 45, -56.0 / 15, 32.0 / 9},
     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}},
    {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84, 0},
    {5179.0 / 57600, 0, 7571.0 / 16695, 393.0 / 640, -92097.0 / 339200, 187.0 / 2100, 1.0 / 40}};

}  // namespace pantin::detail
