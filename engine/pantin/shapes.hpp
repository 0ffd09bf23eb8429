#pragma once
/// Rigid bodies made of shapes: `world.add(RigidBody{.shape = BoxShape{...}, .density = 600})`.
///
/// Mass, mass centre, inertia and principal axes follow from the shapes and the density. Adding
/// checks everything and changes nothing if something is wrong; see joints.hpp.
#include <array>
#include <cstdint>
#include <optional>
#include <pantin/world.hpp>
#include <string>
#include <variant>
#include <vector>

namespace pantin {

// Every shape is given in the frame of its body, moved by `at`.

struct SphereShape {
  Real radius = 0;  // m
  Pose at = {};
};

/// A cylinder with hemispherical ends, along y.
struct CapsuleShape {
  Real radius = 0;       // m
  Real half_length = 0;  // m, of the straight part
  Pose at = {};
};

struct BoxShape {
  Vec3 half_extents{0};  // m
  Pose at = {};
};

/// The convex hull of points that are not coplanar.
struct HullShape {
  std::vector<Vec3> points = {};  // m
  Pose at = {};
};

/// The half-space y <= 0. For bodies that are fixed or kinematic.
struct PlaneShape {
  Real drawn_extent = 50;  // m, as drawn
  Pose at = {};
};

/// A closed surface, triangles anticlockwise seen from outside. For bodies that are fixed or
/// kinematic.
struct MeshShape {
  std::vector<Vec3> points = {};  // m
  std::vector<std::array<std::uint32_t, 3>> triangles = {};
  Pose at = {};
};

/// Terrain: heights[row * columns + column] (m) over x (columns) and z (rows), with its middle at
/// the origin. For bodies that are fixed or kinematic.
struct HeightFieldShape {
  std::uint32_t columns = 0, rows = 0;
  Real spacing_x = 1, spacing_z = 1;  // m
  std::vector<Real> heights = {};     // m
  Pose at = {};
};

/// A cylinder with flat ends, along y.
struct CylinderShape {
  Real radius = 0;       // m
  Real half_length = 0;  // m
  Pose at = {};
};

/// A cone along y with its tip up; the origin is halfway between base and tip.
struct ConeShape {
  Real radius = 0;       // m, of the base
  Real half_height = 0;  // m
  Pose at = {};
};

struct EllipsoidShape {
  Vec3 radii{0};  // m
  Pose at = {};
};

/// A surface of NURBS faces, represented exactly. It collides; if closed, its mass properties are
/// found by quadrature; it may be part of a SurfaceJoint. A closed surface is a solid with its
/// outer side out. An open one, and the wall of a cavity, a closed one with its outer side in, are
/// for bodies that are fixed or kinematic, or whose mass is given.
struct NurbsShape {
  /// Its outer side is in the direction of u x v.
  struct Face {
    int degree_u = 3, degree_v = 3;                // 1 to 25
    std::vector<Real> knots_u = {}, knots_v = {};  // not decreasing; points + degree + 1 of them
    std::vector<Vec3> points = {};                 // m, u outermost: all points along v, then the
                                                   // next row
    std::vector<Real> weights = {};                // above 0, one for each point; empty: 1 for all
    bool periodic_u = false, periodic_v = false;   // both ends coincide
  };
  std::vector<Face> faces = {};
  Real tolerance = 1e-7;  // m: edges of faces that coincide within it are joined
  Pose at = {};
};

using BodyShape =
    std::variant<std::monostate, SphereShape, CapsuleShape, BoxShape, HullShape, PlaneShape,
                 MeshShape, HeightFieldShape, CylinderShape, ConeShape, EllipsoidShape, NurbsShape>;

/// A body, placed by the frame in which its shapes are given; the mass centre may be elsewhere.
///
/// A dynamic body needs shapes with a mass, or `mass` and `inertia`. A given `mass` scales the
/// density.
struct RigidBody {
  Motion motion = Motion::dynamic;
  BodyShape shape = {};
  std::vector<BodyShape> shapes = {};       // additional ones
  Real density = 1000;                      // kg/m^3
  std::optional<Real> mass = {};            // kg
  std::optional<Mat3> inertia = {};         // kg m^2, about the mass centre, in the body's frame
  Vec3 position{0};                         // m
  Quat rotation{1, 0, 0, 0};                // need not be of unit length
  Vec3 velocity{0};                         // m/s, of the mass centre
  Vec3 angular_velocity{0};                 // rad/s, world axes
  std::optional<Collision> collision = {};  // none: it does not collide
  Real drag = Body{}.drag;                  // 1/s
  Real gravity_scale = 1;
  std::uint32_t material = 0;  // index into World::materials
  std::string name = {};
};

Result<Entity> add_to(World& world, const RigidBody& body);

/// Adds the properties of a pair of materials; returns its index in World::material_pairs. An error
/// if a material does not exist, the pair exists already, or a number is invalid. Bodies that touch
/// with the two materials wake.
Result<std::uint32_t> add_to(World& world, const MaterialPair& pair);

}  // namespace pantin
