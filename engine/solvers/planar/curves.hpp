#pragma once
/// Planar curves that touch, slide and roll: their state in the planar solver.
#include <array>
#include <memory>

#include "engine/nurbs/curve_pieces.hpp"
#include "engine/solvers/planar/factor.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin::detail::planar {

/// A contact point of two curves, active or near. A bilateral joint has one.
struct CurvePlace {
  bool used = false;
  bool presses = false;     // it was active in the last step
  bool lies = false;        // straight on straight: the point of a is a material point
  Real t_a = 0, t_b = 0;    // parameters
  Real slip = 0;            // m, of rolling: difference of arc lengths since contact began
  Real push = 0, drag = 0;  // kg m: multipliers of gap and slip in the last step
  Real force = 0,
       along = 0;  // N, mean over the last step, on a: along the normal of b, and left of it

  static void fields(auto& self, auto&& field) {
    field("used", self.used);
    field("presses", self.presses);
    field("lies", self.lies);
    field("t_a", self.t_a);
    field("t_b", self.t_b);
    field("slip", self.slip);
    field("push", self.push);
    field("drag", self.drag);
    field("force", self.force);
    field("along", self.along);
  }
};
inline constexpr std::size_t kMostPlaces = 4;

/// Two bodies of the plane and their curves.
struct FlatCurve {
  Entity owner;
  std::uint32_t contact = 0;   // slot in World::surface_contacts
  std::uint32_t a = 0, b = 0;  // bodies
  std::uint32_t island = 0;
  bool rolls = false, lifts = false;
  struct Side {
    std::shared_ptr<const nurbs::Wire> wire;
    std::shared_ptr<const nurbs::CurvePieces> pieces;
    // For the body's tilt when this was made, with the rounding of its rotation then: kept.
    Vec3 arm{0};     // from the mass centre to the curve's origin, m, in the unrotated body
    Real angle = 0;  // rad, of the curve's axes there

    static void fields(auto& self, auto&& field) {
      field("wire", derived(self.wire));
      field("pieces", derived(self.pieces));
      field("arm", self.arm);
      field("angle", self.angle);
    }
  };
  std::array<Side, 2> sides;
  bool meets_once = false;  // convex curves have one contact point, which needs no search
  bool known = false;       // contact points have been searched
  bool over = false;        // it was released
  bool struck = false;      // its mechanism had other contacts in the last step
  nurbs::ContactStatus how = nurbs::ContactStatus::found;  // reason of the release
  std::array<CurvePlace, kMostPlaces> places;
  Pose searched;  // of a in b, at the last search of all pairs

  static void fields(auto& self, auto&& field) {
    field("owner", derived(self.owner));
    field("contact", derived(self.contact));
    field("a", derived(self.a));
    field("b", derived(self.b));
    field("island", derived(self.island));
    field("rolls", derived(self.rolls));
    field("lifts", derived(self.lifts));
    field("sides", self.sides);
    field("meets_once", derived(self.meets_once));
    field("known", self.known);
    field("over", self.over);
    field("struck", self.struck);
    field("how", passive(self.how));
    field("places", self.places);
    field("searched", self.searched);
  }

  std::size_t most_places() const { return lifts ? kMostPlaces : 1; }
  std::size_t rows_per_place() const { return rolls ? 2 : 1; }
  std::size_t row_count() const { return most_places() * rows_per_place(); }
};

struct Motions;

/// A contact point at the current poses.
struct PlaceNow {
  nurbs::ContactStatus status = nurbs::ContactStatus::lost;
  CurvePlace place;
  Vec3 normal{0}, arm_a{0}, arm_b{0};  // world; from the mass centres
  Real gap = 0;                        // m
};
PlaceNow follow(const FlatCurve& curve, const CurvePlace& from, const Motions& m);

/// The rows of a contact point: of the gap, and of rolling if the curve rolls. If it is null or
/// inactive, the rows are empty but name the bodies, which keeps the pattern.
void append_place_rows(const FlatCurve& curve, const PlaceNow* at, std::vector<Row>& rows);

/// Whether both are convex and one has no straight piece: then they touch in one point at most.
bool meets_once(const FlatCurve& curve);

/// Pose of a in b.
Pose pose_between(const FlatCurve& curve, const Motions& m);

/// Whether a has moved so far in b since `searched` that other pairs may be near.
bool is_search_due(const FlatCurve& curve, const Pose& searched, const Motions& m);

/// Searches all pairs if that is due; drops contact points that are no longer near.
void search_places(FlatCurve& curve, const Motions& m);

}  // namespace pantin::detail::planar
