#pragma once
/// Surface joints: the state that an island keeps of them, and what it finds in a step.
#include <array>
#include <memory>

#include "engine/nurbs/curve_pieces.hpp"
#include "engine/world/surface_contact.hpp"

namespace pantin::detail::lagrangian {

/// Contact point of two surfaces at one time: the coordinates of their joint.
struct SurfaceCoordinates {
  nurbs::PlacePair at;
  std::array<Real, 4> rates{};  // of the parameters, as last computed
  Real time = 0;                // s, of `at`
  Real slip = 0;                // m, of curves: difference of the arc lengths rolled

  static void fields(auto& self, auto&& field) {
    field("at", self.at);
    field("rates", self.rates);
    field("time", self.time);
    field("slip", self.slip);
  }
};

/// The curves of a contact, prepared for arc lengths; or none.
struct SurfaceWays {
  std::shared_ptr<const nurbs::CurvePieces> a, b;

  static void fields(auto& self, auto&& field) {
    field("a", derived(self.a));
    field("b", derived(self.b));
  }
};

/// Further state of a tracked pair.
struct SurfaceMemory {
  SurfaceCoordinates touch;
  bool known = false;                                      // `touch` is a tracked pair
  nurbs::ContactStatus how = nurbs::ContactStatus::found;  // otherwise the joint was released
  Pose searched;                                           // a in b at the last search of all pairs
  bool is_far = false;                                     // that search found no pair near
  bool was_searched = false;
  bool is_least = true;  // the gap is a minimum there
  Real projected = 0;    // N: normal force from the projection of the last step
  Vec3 slip{0};          // world, unit: direction of slip of a on b, where friction slips

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

/// Data from which the rows of a contact were last written.
struct SurfaceFound {
  // In the frame of b, for a at `a_in_b`; one pose is tracked only once a step.
  nurbs::CommonNormal pair;
  Pose a_in_b;
  bool is_fresh = false;
  Vec3 on_b{0}, normal{0};  // world: m, and unit, outwards of b
  Real gap = 0;             // m
  Vec3 tangent[2] = {};     // of the rows of rolling
  Vec3 arm[2] = {};         // from the mass centres to the points, m
  Vec3 from[2] = {};        // on either, in its frame, at the start of this substep
  // The normal as seen from either: at that time, and its rate in the substep, 1/s.
  Vec3 normal_from[2] = {}, normal_rate[2] = {};
  bool knows_rate = false;
  Real opened = 0;  // m/s: opening speed at the start of the substep
  bool is_set_back = false;
  bool gap_follows = false;  // from rolling and other joints: its row is redundant
  bool has_let_go = false;   // lifted off, or began to slip, at the end of this substep
  // For the first slot of a contact: pose of a in b at the start of the substep; least gap, m, at
  // the last search of all pairs.
  Pose begun;
  Real clear = 0;
  // Friction: unit direction of slip that it opposes, normal force (N), and slip speed at the start
  // of this substep.
  Vec3 along{0};
  Real grip = 0, slip_before = 0;
  // Sticking that failed in this substep; or failed in the wrong direction, so it sticks until the
  // substep ends.
  enum class Holds : std::uint8_t { as_it_can, gave_way, anyway } holds = Holds::as_it_can;
  int ends = 0;       // of slips in this step
  bool jams = false;  // friction increases its own normal force without bound: it sticks
};

}  // namespace pantin::detail::lagrangian
