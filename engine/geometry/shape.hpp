#pragma once
/// Solid shapes: what a body looks like and what its mass follows from.
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

struct Surface;  // see surface.hpp

enum class ShapeKind : std::uint8_t {
  sphere,
  capsule,
  box,
  hull,          // the convex hull of points
  plane,         // the half-space y <= 0: only for fixed and driven bodies
  mesh,          // a closed surface of triangles: likewise
  height_field,  // heights along y over a grid of x and z: likewise
};
constexpr ShapeKind last_of(ShapeKind) { return ShapeKind::height_field; }

/// A solid in a frame of its own.
///
/// `size` in metres: sphere (radius, -, -); capsule (radius, half of the straight part, -), its
/// axis along local y; box half extents; plane (extent of its picture, -, -). hull, mesh and
/// height_field have their size from `surface`. `local` places it in the body's mass-centre frame.
struct Shape {
  ShapeKind kind = ShapeKind::sphere;
  Vec3 size{0.1, 0, 0};
  Pose local;
  std::uint32_t material = 0;  // index into World::materials
  std::shared_ptr<const Surface> surface = nullptr;  // of hull, mesh, height_field

  static void fields(auto& self, auto&& field) {
    field("kind", self.kind);
    field("size", self.size);
    field("local", self.local);
    field("material", passive(self.material));
    field("surface", self.surface);
  }
  /// Null if the surface is there and of the kind, or what is wrong; asked after reading.
  const char* restored() const;
};

/// The shapes of one body.
struct Shapes {
  std::vector<Shape> parts;

  static void fields(auto& self, auto&& field) {
    field("parts", self.parts);
  }
};

/// Mass, mass centre and inertia about that centre, in the frame the shapes are placed in.
struct MassProperties {
  Real mass = 0;    // kg
  Vec3 centre{0};   // m
  Mat3 inertia{0};  // kg m^2, about `centre`
};

/// Volume in m^3; of a plane or a height field, which have no end, 0.
Real volume(const Shape& shape);

/// Mass properties of one solid of constant `density` (kg/m^3), in the frame of `shape.local`.
/// Exact for hulls and meshes, by tetrahedra. A plane or a height field has no mass.
MassProperties mass_properties(const Shape& shape, Real density);

/// Sum of two solids given in one frame (parallel axes).
MassProperties combine(const MassProperties& a, const MassProperties& b);

/// Inertia of three principal axes: `rotation` turns principal axes into the frame of the tensor.
struct PrincipalInertia {
  Vec3 moments{1};
  Quat rotation{1, 0, 0, 0};
};

/// Diagonalises a symmetric tensor by Jacobi rotations; the axes stay as near to the given ones as
/// the tensor allows, so a diagonal tensor returns itself and no turn.
PrincipalInertia principal_inertia(const Mat3& tensor);

/// Three positive moments that some solid body can have: each at most the sum of the other two.
bool is_possible_inertia(Vec3 moments);

}  // namespace pantin
