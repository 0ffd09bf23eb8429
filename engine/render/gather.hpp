#pragma once
/// Packs the visible objects of a World into arrays for the GPU. Positions are relative to the eye:
/// far from the world's origin single precision would be too coarse.
#include <array>
#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "engine/render/bounds.hpp"
#include "engine/render/eye.hpp"
#include "engine/render/meshes.hpp"

namespace pantin::detail {

/// One solid: core and skin of its mesh (see MeshVertex), pose, material.
struct Instance {
  float turn[4];  // quaternion x, y, z, w
  float position[3];
  float metallic;
  float core[3];  // half extents of the core, m
  float skin;     // m
  float colour[3];
  float roughness;
};

/// One of the two edges of a cable's ribbon at one of its points; the shader turns it towards the
/// eye.
struct RibbonVertex {
  float position[3];
  float tangent[3];
  float side;  // -1 or 1
};

/// All instances of one surface.
struct SurfaceSolids {
  std::shared_ptr<const Surface> surface;
  const Shape* smooth = nullptr;  // the shape that the surface substitutes
  std::vector<Instance> instances = {};
};

/// A substitute surface for a shape without one.
struct StandIn {
  Shape shape;
  std::shared_ptr<const Surface> surface = nullptr;
};

/// Groups of balls; the hull of each group contains a drawn object.
struct Hulls {
  std::vector<Ball> balls;
  std::vector<std::size_t> ends;  // of each group in `balls`

  void clear() { balls.clear(), ends.clear(); }
  /// Ends a group: the balls added since the last one, if there are any.
  void end() {
    if (balls.size() > (ends.empty() ? 0 : ends.back())) ends.push_back(balls.size());
  }
  std::size_t size() const { return ends.size(); }
  std::span<const Ball> operator[](std::size_t i) const {
    const std::size_t first = i == 0 ? 0 : ends[i - 1];
    return std::span(balls).subspan(first, ends[i] - first);
  }
};

struct DrawList {
  std::array<std::vector<Instance>, kMeshCount> solids;
  std::vector<SurfaceSolids> surfaces;
  std::unordered_map<const Surface*, std::size_t> surface_indices;  // index in `surfaces`
  // By kind and size; kept between pictures.
  std::map<std::tuple<ShapeKind, Real, Real, Real>, StandIn> stand_ins;
  // Solids of curves in contact; kept as well.
  struct CurveSolid {
    std::shared_ptr<const nurbs::Wire> curve;  // owned, because its address is the key
    std::shared_ptr<const Surface> solid;
  };
  std::unordered_map<const nurbs::Wire*, CurveSolid> curve_solids;
  std::vector<RibbonVertex> ribbon;
  std::vector<std::uint32_t> ribbon_indices;  // triangles
  Hulls solids_around;                        // around all drawn objects except grounds
  Hulls grounds;                              // around planes and height fields
  std::vector<Ball> movers;                   // around moving objects, cables included
  std::vector<Ball> fillings;                 // inside solids, as occluders of the ground
};

/// The mesh that draws a rounded box.
struct DrawnBox {
  Vec3 core{0};      // m, half extents
  Real skin = 0;     // m
  Mesh mesh = kBox;  // kRound32 for any of the round ones
};
/// Sharp edges get a bevel.
DrawnBox drawn_box(const RoundedBox& box);
/// What `traits_of` says of a shape, if it is a rounded box.
std::optional<RoundedBox> rounded_box(const Shape& shape);

inline constexpr Real kStringRadius = 0.0012;  // m

/// Clears and fills `to`. Bodies with non-finite poses are left out, and so are planes that
/// coincide with the ground of `view`.
void gather(const PosedWorld& scene, const View& view, const Eye& eye, DrawList& to);

}  // namespace pantin::detail
