#pragma once
/// Two bodies whose surfaces touch, slide or roll on one another: the internal form of the joint
/// `SurfaceJoint` of <pantin/joints.hpp>.
///
/// Internal but for the two enums; installed because a World holds it.
#include <memory>

#include "engine/base/fields.hpp"
#include "engine/nurbs/closest.hpp"
#include "engine/nurbs/common_normal.hpp"
#include "engine/world/entity.hpp"

namespace pantin {

/// The relative motion of two surfaces in contact.
enum class SurfaceMotion : std::uint8_t {
  sliding,              // without friction: 1 row
  rolling,              // without slip; they may spin about the common normal: 3 rows
  rolling_without_spin  // 4 rows
};
constexpr SurfaceMotion last_of(SurfaceMotion) { return SurfaceMotion::rolling_without_spin; }

/// What happens if the contact point leaves a surface over its rim, reaches a singular point
/// without a normal, or the surfaces become conforming.
enum class OnRim : std::uint8_t {
  stop,    // the step is not taken, and its report says so
  release  // the joint releases permanently
};
constexpr OnRim last_of(OnRim) { return OnRim::release; }

namespace detail {

namespace nurbs {
constexpr ContactStatus last_of(ContactStatus) { return ContactStatus::lost; }
}  // namespace nurbs

/// A surface, or a curve instead, fixed in a body.
struct ContactSurface {
  Pose pose;  // of its frame in the body's mass-centre frame
  std::shared_ptr<const nurbs::Skin> skin;
  std::shared_ptr<const nurbs::Wire> curve;

  static void fields(auto& self, auto&& field) {
    field("pose", self.pose);
    field("skin", self.skin);
    field("curve", self.curve);
  }
};

/// A point where two surfaces touch, or are nearest: a result of the last step.
struct SurfaceSpot {
  bool touches = false;
  bool slips = false;        // the contact slips there
  Vec3 point{0}, normal{0};  // world: on b, m, and out of b
  Vec3 force{0};             // N, on b, mean over the step
  Real gap = 0;              // m

  static void fields(auto& self, auto&& field) {
    field("touches", self.touches);
    field("slips", self.slips);
    field("point", self.point);
    field("normal", self.normal);
    field("force", self.force);
    field("gap", self.gap);
  }
};
/// The most simultaneous contact points of two surfaces.
inline constexpr std::size_t kMostSpots = 8;

/// Two bodies and the surfaces by which they touch. Either b has a skin and a has a skin or a
/// curve, or both have curves in the planes z = 0 of their frames. Only the Lagrangian solver
/// supports it.
struct SurfaceContact {
  Entity a, b;
  ContactSurface on_a, on_b;
  SurfaceMotion motion = SurfaceMotion::sliding;
  bool lifts = false;  // unilateral: may separate and touch again; otherwise bilateral
  OnRim on_rim = OnRim::stop;
  // Coulomb's coefficient, sliding or rolling; below 0: sliding is frictionless, rolling never
  // slips.
  Real friction = -1;
  std::uint8_t spots = 1;  // most simultaneous contact points; 1 for a bilateral contact
  // The contact, or the nearest points. Steps update it. A curve has its parameter in `u`.
  nurbs::PlacePair at;
  bool known = false;  // `at` is valid
  bool over = false;   // it has released permanently
  // Results of the last step:
  nurbs::ContactStatus status = nurbs::ContactStatus::found;
  bool touches = false, slips = false;
  Vec3 point{0}, normal{0};                      // world: on b, m, and out of b
  Vec3 force{0};                                 // N, on b, mean over the step
  Real gap = 0;                                  // m
  std::array<SurfaceSpot, kMostSpots - 1> more;  // further contact points; normal 0: unused

  static void fields(auto& self, auto&& field) {
    field("a", self.a);
    field("b", self.b);
    field("on_a", self.on_a);
    field("on_b", self.on_b);
    field("motion", self.motion);
    field("lifts", self.lifts);
    field("on_rim", self.on_rim);
    field("friction", self.friction);
    field("spots", self.spots);
    field("at", self.at);
    field("known", self.known);
    field("over", self.over);
    field("status", passive(self.status));
    field("touches", passive(self.touches));
    field("slips", passive(self.slips));
    field("point", passive(self.point));
    field("normal", passive(self.normal));
    field("force", passive(self.force));
    field("gap", passive(self.gap));
    field("more", passive(self.more));
  }
  /// Checks for missing surfaces, points off them and invalid friction; returns null, or the fault.
  const char* restored() const;
};

/// Whether a place is on a surface or curve, within its parameter range.
bool is_on(const ContactSurface& surface, const nurbs::Place& place);

}  // namespace detail
}  // namespace pantin
