#pragma once
/// Packs what a World shows into the arrays that the graphics card reads. Positions are relative to
/// the eye: far from the world's origin single precision would show.
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

/// One of the two borders of a cable at one of its points; the shader rotates it towards the eye.
struct RibbonVertex {
  float position[3];
  float tangent[3];
  float side;  // -1 or 1
};

/// All solids of one surface.
struct SurfaceSolids {
  std::shared_ptr<const Surface> surface;
  const Shape* smooth = nullptr;  // that the surface stands for
  std::vector<Instance> instances = {};
};

/// A surface that stands for a shape without one.
struct StandIn {
  Shape shape;
  std::shared_ptr<const Surface> surface = nullptr;
};

/// Balls in groups; the hull of each group holds something that is drawn.
struct Hulls {
  std::vector<Ball> balls;
  std::vector<std::size_t> ends;  // of each group in `balls`

  void clear() { balls.clear(), ends.clear(); }
  /// Ends a group: what was added to `balls` since the last one; none if that is nothing.
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
  std::unordered_map<const Surface*, std::size_t> surface_indices;  // in `surfaces`
  // By kind and size; kept from picture to picture.
  std::map<std::tuple<ShapeKind, Real, Real, Real>, StandIn> stand_ins;
  // Of curves that touch; kept likewise.
  struct CurveSolid {
    std::shared_ptr<const nurbs::Wire> curve;  // held: its address names it
    std::shared_ptr<const Surface> solid;
  };
  std::unordered_map<const nurbs::Wire*, CurveSolid> curve_solids;
  std::vector<RibbonVertex> ribbon;
  std::vector<std::uint32_t> ribbon_indices;  // triangles
  Hulls solids_around;                        // around all that is drawn, grounds aside
  Hulls grounds;                              // around planes and height fields
  std::vector<Ball> movers;                   // around what is not fixed, cables included
  std::vector<Ball> fillings;                 // within the solids: what keeps light from the ground
};

inline constexpr Real kStringRadius = 0.0012;  // m

/// Clears `to` and fills it; bodies with poses that are not finite are left out, and so are planes
/// that the ground of `view` shows already.
void gather(const PosedWorld& scene, const View& view, const Eye& eye, DrawList& to);

}  // namespace pantin::detail
