#pragma once
/// Where surfaces touch: what an island keeps of it, and what it finds in a step.
#include <array>
#include <memory>

#include "engine/nurbs/curve_pieces.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin::detail::lagrangian {

/// Where two surfaces touch at one time: the coordinates of their contact.
struct SurfaceCoordinates {
  nurbs::PlacePair at;
  std::array<Real, 4> rates{};  // of the parameters when they were found last
  Real time = 0;                // s, of `at`
  Real slip = 0;                // m, of curves: their ways since they began to roll do not match

  static void fields(auto& self, auto&& field) {
    field("at", self.at);
    field("rates", self.rates);
    field("time", self.time);
    field("slip", self.slip);
  }
};

/// The curves of a contact, made ready to tell ways along them; or none.
struct SurfaceWays {
  std::shared_ptr<const nurbs::CurvePieces> a, b;

  static void fields(auto& self, auto&& field) {
    field("a", derived(self.a));
    field("b", derived(self.b));
  }
};

/// State of a contact of surfaces besides.
struct SurfaceMemory {
  SurfaceCoordinates touch;
  bool known = false;                                      // where they touch
  nurbs::ContactStatus how = nurbs::ContactStatus::found;  // else the joint has let go
  Pose searched;        // a in b when all pairs were looked at last
  bool is_far = false;  // then there was none near
  bool was_searched = false;
  bool is_least = true;  // the gap has its least there
  Real projected = 0;    // N: what the projection of the last step pressed them together with
  Vec3 slip{0};          // world, unit: the way that a slips on b, where friction does not hold

  bool is_over() const { return how != nurbs::ContactStatus::found; }

  static void fields(auto& self, auto&& field) {
    field("touch", self.touch);
    field("known", self.known);
    field("how", self.how);
    field("searched", self.searched);
    field("is_far", self.is_far);
    field("was_searched", self.was_searched);
    field("is_least", self.is_least);
    field("projected", self.projected);
    field("slip", self.slip);
  }
};

/// What the rows of a contact were written from last.
struct SurfaceFound {
  // In the frame of b, where a stood at `a_in_b`; such a pose is not looked at twice in a step.
  nurbs::CommonNormal pair;
  Pose a_in_b;
  bool is_fresh = false;
  Vec3 on_b{0}, normal{0};  // world: m, and unit, outwards of b
  Real gap = 0;             // m
  Vec3 tangent[2] = {};     // of the rows of rolling
  Vec3 arm[2] = {};         // from the mass centres to the points, m
  Vec3 from[2] = {};        // on either, in its frame, at the start of this part of the step
  // The normal as seen from either: then, and how it turned in the part, 1/s.
  Vec3 normal_from[2] = {}, normal_rate[2] = {};
  bool knows_rate = false;
  Real opened = 0;  // m/s: how fast they came apart then
  bool is_set_back = false;
  bool gap_follows = false;  // from rolling and other joints: its row is redundant
  bool has_let_go = false;   // lifted off, or began to slip, at the end of this part
  // Of the first place of a contact: where a stood in the frame of b then, and what was the least
  // gap when all pairs were looked at, m.
  Pose begun;
  Real clear = 0;
  // Friction: the unit way that it acts against, what presses the surfaces together (N), and how
  // fast they slipped at the start of this part of the step.
  Vec3 along{0};
  Real grip = 0, slip_before = 0;
  // What held gave way in this part of the step; or did, and did not slip: it holds for this part.
  enum class Holds : std::uint8_t { as_it_can, gave_way, anyway } holds = Holds::as_it_can;
  int ends = 0;       // of slips in this step
  bool jams = false;  // friction that presses itself together without end: nothing slips there
};

}  // namespace pantin::detail::lagrangian
