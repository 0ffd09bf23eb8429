#include "engine/nurbs/net.hpp"

#include <algorithm>

namespace pantin::detail::nurbs {
namespace {

/// The numbers of the images of a control point along one direction.
std::vector<int> images_along(const Knots& knots, int i) {
  if (!knots.is_periodic) return {i};
  // Clamped ends repeat the first control point, others the first `degree` of them.
  const int repeated = knots.multiplicity(knots.low()) >= knots.degree ? 1 : knots.degree;
  const int period = knots.count() - repeated;
  std::vector<int> all;
  for (int at = i % period; at < knots.count(); at += period) all.push_back(at);
  return all;
}

/// The basis functions that are not zero at a parameter, and the number of the first.
struct BasisAt {
  Basis values;
  int first = 0, degree = 0;

  BasisAt(const Knots& knots, Real t) : degree(knots.degree) {
    const Real at = knots.inside(t);
    const int span = knots.span_at(at);
    write_basis(knots, {span, at}, 0, values);
    first = span - degree;
  }
  Real at(int i) const {
    const bool is_here = i >= first && i <= first + degree;
    return is_here ? values[0][static_cast<std::size_t>(i - first)] : 0;
  }
};

}  // namespace

std::vector<std::uint32_t> images_of(const Curve& curve, std::uint32_t point) {
  std::vector<std::uint32_t> all;
  for (const int i : images_along(curve.knots, static_cast<int>(point)))
    all.push_back(static_cast<std::uint32_t>(i));
  return all;
}

std::vector<std::uint32_t> images_of(const Surface& surface, std::uint32_t point) {
  const int columns = surface.v.count();
  const int i = static_cast<int>(point) / columns, j = static_cast<int>(point) % columns;
  std::vector<std::uint32_t> all;
  for (const int k : images_along(surface.u, i))
    for (const int l : images_along(surface.v, j))
      all.push_back(static_cast<std::uint32_t>(k * columns + l));
  return all;
}

Real share_of(const Curve& curve, std::span<const std::uint32_t> images, Real t) {
  const BasisAt basis(curve.knots, t);
  Real sum = 0, own = 0;
  for (int i = basis.first; i <= basis.first + basis.degree; ++i) {
    const auto number = static_cast<std::uint32_t>(i);
    const Real part = basis.at(i) * curve.points[number].w;
    sum += part;
    if (std::find(images.begin(), images.end(), number) != images.end()) own += part;
  }
  return own / sum;
}

Real share_of(const Surface& surface, std::span<const std::uint32_t> images,
              std::array<Real, 2> at) {
  const BasisAt u(surface.u, at[0]), v(surface.v, at[1]);
  Real sum = 0, own = 0;
  for (int i = u.first; i <= u.first + u.degree; ++i)
    for (int j = v.first; j <= v.first + v.degree; ++j) {
      const auto number = static_cast<std::uint32_t>(i * surface.v.count() + j);
      const Real part = u.at(i) * v.at(j) * surface.points[number].w;
      sum += part;
      if (std::find(images.begin(), images.end(), number) != images.end()) own += part;
    }
  return own / sum;
}

}  // namespace pantin::detail::nurbs
