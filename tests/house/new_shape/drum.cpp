// A round block along y with sharp rims, known by its support function: size (radius, half of its
// length, -).
#include "engine/geometry/kinds/parts.hpp"

namespace pantin::detail::shape_kinds {
namespace {

constexpr SizeKey kSizes[] = {{"radius", "Of the drum."},
                              {"length", "From end to end.", 1, 1, 0.5}};

Real volume(const Shape& shape) { return 2 * kPi * shape.size.x * shape.size.x * shape.size.y; }

Vec3 unit_moments(const Shape& shape) {
  const Real r = shape.size.x, h = shape.size.y;
  return {r * r / 4 + h * h / 3, r * r / 2, r * r / 4 + h * h / 3};
}

Vec3 support(const Shape& shape, Vec3 d) {
  const Real across = std::hypot(d.x, d.z), out = across > 0 ? shape.size.x / across : 0;
  return {out * d.x, d.y < 0 ? -shape.size.y : shape.size.y, out * d.z};
}

Real inner_radius(const Shape& shape) { return glm::min(shape.size.x, shape.size.y); }

}  // namespace

constinit const ShapeTraits drum{
    .about = "A round block along y.",
    .sizes = kSizes,
    .support = support,
    .volume = volume,
    .unit_moments = unit_moments,
    .inner_radius = inner_radius,
};

}  // namespace pantin::detail::shape_kinds
