#pragma once
/// Curves of the plane that touch, slide and roll: what the planar solver keeps of them.
#include <array>
#include <memory>

#include "engine/nurbs/curve_pieces.hpp"
#include "engine/solvers/planar/factor.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin::detail::planar {

/// Where two curves touch, or may next. A joint that is held has one such place.
struct CurvePlace {
  bool used = false;
  bool presses = false;     // it bore a force in the last step
  bool lies = false;        // straight on straight: the point of a is one of its material
  Real t_a = 0, t_b = 0;    // parameters
  Real slip = 0;            // m, of rolling: gone along both since they met
  Real push = 0, drag = 0;  // kg m: what closed the gap and the slip in the last step
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
    // As the body was tilted when this was made, with the rounding of its turn then: kept.
    Vec3 arm{0};  // from the mass centre to the curve's origin, m, in the body as it lies unturned
    Real angle = 0;  // rad, of the curve's axes there

    static void fields(auto& self, auto&& field) {
      field("wire", derived(self.wire));
      field("pieces", derived(self.pieces));
      field("arm", self.arm);
      field("angle", self.angle);
    }
  };
  std::array<Side, 2> sides;
  bool meets_once = false;  // convex ones have one place: what is followed needs no search
  bool known = false;       // where they touch has been looked for
  bool over = false;        // it has let go
  bool struck = false;      // something else touched its mechanism in the last step
  nurbs::ContactStatus how = nurbs::ContactStatus::found;  // why it let go
  std::array<CurvePlace, kMostPlaces> places;
  Pose searched;  // of a in b, when all pairs were looked at

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

/// A place as the bodies stand.
struct PlaceNow {
  nurbs::ContactStatus status = nurbs::ContactStatus::lost;
  CurvePlace place;
  Vec3 normal{0}, arm_a{0}, arm_b{0};  // world; from the mass centres
  Real gap = 0;                        // m
};
PlaceNow follow(const FlatCurve& curve, const CurvePlace& from, const Motions& m);

/// The rows of a place: of the gap, and of rolling if the curve does. Without a place, or where it
/// does not press, they name the bodies and hold nothing.
void append_place_rows(const FlatCurve& curve, const PlaceNow* at, std::vector<Row>& rows);

/// Whether both are convex, and one of them bends everywhere: then they meet in one place at most.
bool meets_once(const FlatCurve& curve);

/// Where a stands as seen from b.
Pose pose_between(const FlatCurve& curve, const Motions& m);

/// Whether a has moved so far in b since it stood at `searched` that other pairs may be near.
bool is_search_due(const FlatCurve& curve, const Pose& searched, const Motions& m);

/// Looks at all pairs where that is due; places that are no longer near are dropped.
void search_places(FlatCurve& curve, const Motions& m);

}  // namespace pantin::detail::planar
