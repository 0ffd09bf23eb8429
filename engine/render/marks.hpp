#pragma once
/// Marks of the debug view: joints, limits, contacts, pins and joint drives, drawn over the
/// picture.
#include <algorithm>
#include <span>
#include <vector>

#include "engine/render/bounds.hpp"
#include "engine/render/overlay.hpp"

namespace pantin::detail {

/// Colours of the marks, sRGB.
namespace ink {
inline constexpr Vec3 kAxes[3] = {{0.92, 0.25, 0.22}, {0.25, 0.75, 0.28}, {0.25, 0.45, 0.95}};
inline constexpr Vec3 kJoint{0.10, 0.80, 0.85}, kOpenJoint{1.0, 0.1, 0.1};
inline constexpr Vec3 kPin{0.98, 0.78, 0.12}, kSlack{1.0, 0.55, 0.10};
inline constexpr Vec3 kRange{0.66, 0.50, 1.0}, kHinge{0.80, 0.86, 0.92}, kLocked{0.72, 0.74, 0.80};
inline constexpr Vec3 kContact{0.45, 0.95, 0.30}, kNear{0.55, 0.62, 0.50}, kSlide{1.0, 0.95, 0.75};
inline constexpr Vec3 kTrailA{0.98, 0.62, 0.10}, kTrailB{0.30, 0.85, 0.95};  // on a, on b
inline constexpr Vec3 kForce{1.0, 0.50, 0.15};  // of joints, cables and pins
inline constexpr Vec3 kMuscle{0.98, 0.45, 0.80};
inline constexpr Vec3 kTie{0.05, 0.60, 0.42};     // axes of translation, distances, springs
inline constexpr Vec3 kWarning{1.0, 0.25, 0.15};  // at a stop, out of reach, at the torque limit
}  // namespace ink

/// Draws lines between points of the world; points behind the eye are skipped.
class Pen {
 public:
  Pen(OverlayList& list, const Eye& eye) : list_(list), eye_(eye) {}

  const Eye& eye() const { return eye_; }
  /// Width of a thin line: 1.5 pixels in a picture of 720 rows.
  Real fine() const { return std::max(1.0, eye_.height / 480.0); }
  bool sees(Vec3 point) const {
    return is_finite(point) && eye_.depth(point) > 1e-3 * eye_.distance;
  }
  /// The length at `point` that covers this many pixels, m.
  Real metres(Vec3 point, Real pixels) const { return pixels * eye_.pixel() * eye_.depth(point); }

  /// `width`, `radius` and `reach` are in pixels.
  void line(Vec3 a, Vec3 b, Real width, const Paint& paint);
  void dot(Vec3 centre, Real radius, Vec3 colour);
  void square(Vec3 centre, Real half, Vec3 colour);
  void ring(Vec3 centre, Real radius, Real width, Vec3 colour);
  void cross(Vec3 centre, Real reach, Real width, Vec3 colour);
  void triangle(Vec3 a, Vec3 b, Vec3 c, const Paint& paint);
  void path(std::span<const Vec3> points, Real width, const Paint& paint);
  /// A translucent fan from `apex` to a rim.
  void fan(Vec3 apex, std::span<const Vec3> rim, Vec3 colour);

 private:
  OverlayList& list_;
  const Eye& eye_;
};

/// A circular arc about `axis` (unit) around `centre`, from angle `low` to `high`. Angle 0 is the
/// direction of `zero`, whose length is the radius.
struct Arc {
  Vec3 centre{0}, axis{1, 0, 0}, zero{0, 1, 0};
  Real low = 0, high = 0;  // rad
};
std::vector<Vec3> points_of(const Arc& arc);

/// All marks: see Overlay::joints.
void add_marks(const PosedWorld& scene, Pen& pen);

/// Contacts with their forces; part of add_marks.
void add_contact_marks(const PosedWorld& scene, Pen& pen);
/// Contact points of surface joints, with tangent plane and normal; part of add_marks.
void add_surface_marks(const PosedWorld& scene, Pen& pen);
/// See Overlay::trails.
void add_trails(const PosedWorld& scene, std::span<const Overlay::Trail> trails, Pen& pen);
/// Rings: see Overlay::doubts.
void add_doubts(std::span<const Vec3> places, Pen& pen);
/// Arrows: see Overlay::forces.
void add_forces(const World& world, std::span<const Overlay::Arrow> forces, Pen& pen);

/// Ranges and present coordinates of joints. Sectors of hinges and universal joints; cones of ball
/// joints with an arc for the twist; in the warning colour at a stop. Axes of hinges; squares at
/// locked joints; lines of translations; lines and zigzags of distances and springs. The size is
/// two thirds of the smaller body.
void add_turn_marks(const PosedWorld& scene, Pen& pen);

/// The length of marks at a joint, m; 0 if they would be too small to read.
Real mark_size(const PosedWorld& scene, const Link& link, Vec3 at, const Pen& pen);

}  // namespace pantin::detail
