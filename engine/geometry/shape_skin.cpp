#include "engine/geometry/shape_skin.hpp"

#include "engine/geometry/surface.hpp"
#include "engine/nurbs/makers.hpp"

namespace pantin::detail {
namespace {

constexpr Real kPlane = 1000;      // m, side of the square that stands for a plane
constexpr Real kTolerance = 1e-9;  // m, of edges that join

std::shared_ptr<const nurbs::Skin> of_face(nurbs::Surface face) {
  return std::make_shared<const nurbs::Skin>(std::vector{std::move(face)}, kTolerance);
}

/// y up, at a height.
nurbs::Frame upright(Real height) { return {{0, height, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}}; }

}  // namespace

std::shared_ptr<const nurbs::Skin> skin_of(const Shape& shape) {
  const Vec3 size = shape.size;
  switch (shape.kind) {
    case ShapeKind::sphere:
      return std::make_shared<const nurbs::Skin>(nurbs::Skin::ellipsoid(Vec3(size.x)));
    case ShapeKind::ellipsoid:
      return std::make_shared<const nurbs::Skin>(nurbs::Skin::ellipsoid(size));
    case ShapeKind::cylinder:
      return of_face(nurbs::cylinder(upright(-size.y), size.x, 2 * size.y));
    case ShapeKind::plane:
      return of_face(nurbs::plane(upright(0), kPlane, kPlane));
    case ShapeKind::nurbs:
      return shape.surface ? shape.surface->skin : nullptr;
    default:  // not smooth: no skin
      return nullptr;
  }
}

}  // namespace pantin::detail
