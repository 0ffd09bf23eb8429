#pragma once
/// Shapes of bodies, for rendering, collision and mass properties.
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"
#include "engine/geometry/kind_list.hpp"

namespace pantin {

namespace detail {
struct Surface;  // see surface.hpp
}

/// Each kind is described in its file under kinds/.
enum class ShapeKind : std::uint8_t {
#define PANTIN_ENUMERATOR(word) word,
  PANTIN_SHAPE_KINDS(PANTIN_ENUMERATOR)
#undef PANTIN_ENUMERATOR
};
constexpr ShapeKind last_of(ShapeKind) {
#define PANTIN_COUNT(word) +1
  return static_cast<ShapeKind>(PANTIN_SHAPE_KINDS(PANTIN_COUNT) - 1);
#undef PANTIN_COUNT
}

/// A shape in its own frame.
///
/// `size` in metres: sphere (radius, -, -); capsule (radius, half of the straight part, -), its
/// axis along local y; box half extents; plane (extent of its picture, -, -); cylinder (radius,
/// half of its length, -) and cone (radius, half of its height, -), along local y; ellipsoid its
/// radii; of every kind, what `sizes` of its traits says. hull, mesh, height_field and nurbs have
/// their size from `surface`. `local` places it in the body's mass-centre frame.
struct Shape {
  ShapeKind kind = ShapeKind::sphere;
  Vec3 size{0.1, 0, 0};
  Pose local;
  std::uint32_t material = 0;                                // index into World::materials
  std::shared_ptr<const detail::Surface> surface = nullptr;  // of hull, mesh, height_field, nurbs

  static void fields(auto& self, auto&& field) {
    field("kind", self.kind);
    field("size", self.size);
    field("local", self.local);
    field("material", passive(self.material));
    field("surface", self.surface);
  }
  /// Null if the surface is there and of the kind, or the error; called after reading.
  const char* restored() const;
};

/// The shapes of one body.
struct Shapes {
  std::vector<Shape> list;

  static void fields(auto& self, auto&& field) { field("list", self.list); }
};

/// Mass, mass centre and inertia about that centre, in the frame the shapes are placed in.
struct MassProperties {
  Real mass = 0;    // kg
  Vec3 centre{0};   // m
  Mat3 inertia{0};  // kg m^2, about `centre`
};

/// Volume in m^3; 0 for a plane or a height field, which are unbounded.
Real volume(const Shape& shape);

/// Mass properties of one solid of constant `density` (kg/m^3), in the frame of `shape.local`.
/// Exact for hulls and meshes, by tetrahedra. A plane or a height field has no mass.
MassProperties mass_properties(const Shape& shape, Real density);

/// Sum of two mass properties in one frame (parallel axis theorem).
MassProperties combine(const MassProperties& a, const MassProperties& b);

/// Principal moments; `rotation` maps principal axes to the frame of the tensor.
struct PrincipalInertia {
  Vec3 moments{1};
  Quat rotation{1, 0, 0, 0};
};

/// Diagonalises a symmetric tensor by Jacobi rotations; the axes stay as near to the given ones as
/// the tensor allows, so a diagonal tensor returns itself and the identity.
PrincipalInertia principal_inertia(const Mat3& tensor);

/// Whether the moments are physical: positive, each at most the sum of the other two.
bool is_possible_inertia(Vec3 moments);

}  // namespace pantin
