#pragma once
/// The words under "type" of faces and curves in scene files.
#include <string_view>

namespace pantin::detail {

inline constexpr std::string_view kFaceTypes[] = {
    "nurbs", "plane",      "cylinder",  "cone",  "sphere",       "ellipsoid",
    "torus", "revolution", "extrusion", "sweep", "interpolation"};
enum class FaceType {
  nurbs,
  plane,
  cylinder,
  cone,
  sphere,
  ellipsoid,
  torus,
  revolution,
  extrusion,
  sweep,
  interpolation
};

inline constexpr std::string_view kCurveTypes[] = {
    "nurbs",  "line", "arc",  "circle", "ellipse",      "interpolation", "outline",
    "joined", "gear", "rack", "cam",    "geneva_wheel", "geneva_disc",   "helix"};
enum class CurveType {
  nurbs,
  line,
  arc,
  circle,
  ellipse,
  interpolation,
  outline,
  joined,
  gear,
  rack,
  cam,
  geneva_wheel,
  geneva_disc,
  helix
};
/// The laws of a cam, in the order of nurbs::CamLaw.
inline constexpr std::string_view kCamLaws[] = {"cycloidal", "3-4-5"};

/// The relative motion of two surfaces in contact, and the behaviour at their rims: in the order of
/// SurfaceMotion and OnRim.
inline constexpr std::string_view kSurfaceMotions[] = {"sliding", "rolling",
                                                       "rolling_without_spin"};
inline constexpr std::string_view kOnRims[] = {"stop", "release"};

}  // namespace pantin::detail
