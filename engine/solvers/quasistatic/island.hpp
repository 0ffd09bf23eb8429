#pragma once
/// State of the quasi-static solver in a World: an island is one lamina.
#include <string_view>
#include <vector>

#include "engine/modes/stepper.hpp"
#include "engine/solvers/planar/plane.hpp"
#include "engine/world/lamina.hpp"
#include "engine/world/memory.hpp"
#include "engine/world/partition.hpp"
#include "engine/world/world.hpp"

namespace pantin::detail::quasistatic {

/// Which method moves a lamina.
enum class Phase : std::uint8_t { modes, dynamics };
constexpr Phase last_of(Phase) { return Phase::dynamics; }

/// Why the quasi-static method found no motion.
enum class Why : std::uint8_t {
  none,
  squeezed,
  no_balance,
  conflict,
  unresolved,
  free_motion,
  at_corner,
  crowded,
  ambiguous,
  zeno
};
constexpr Why last_of(Why) { return Why::zeno; }
/// A clause: "every motion penetrates a finger".
const char* word_for(Why why);

struct IslandScratch {
  modes::Stepper stepper;
  std::vector<modes::Vec2> outline;      // in the mass-centre frame
  std::vector<modes::Finger> fingers;    // current, in the order of the component's
  std::vector<std::uint32_t> finger_of;  // by finger: its number in the component
  planar::Plane plane;
  Pose start;            // of the body, before the last step
  bool stepped = false;  // in the last step
  bool changed = false;  // of phase, likewise
  int switches = 0;      // of modes, likewise
};

struct Island {
  Entity body;
  std::uint32_t slot = 0;
  bool unfit = false;
  Real turned = 0;  // rad, whole turns counted
  Phase phase = Phase::modes;
  Why why = Why::none;                        // of the last change to dynamics
  modes::Motion motion;                       // the active mode
  std::vector<planar::PlaneContact> touches;  // of the last step of dynamics
  Real calm = 0;                              // s: how long a mode has agreed with dynamics
  bool lost = false;                          // the last step gave numbers that are not finite
  Scratch<IslandScratch> scratch;

  static void fields(auto& self, auto&& field) {
    field("body", derived(self.body));
    field("slot", derived(self.slot));
    field("unfit", derived(self.unfit));
    field("turned", self.turned);
    field("phase", self.phase);
    field("why", self.why);
    field("motion", self.motion);
    field("touches", self.touches);
    field("calm", self.calm);
    field("lost", derived(self.lost));
    field("scratch", derived(self.scratch));
  }
};

struct Islands {
  static constexpr std::string_view name = "quasistatic";  // in saved Worlds
  std::vector<Island> list;

  static void fields(auto& self, auto&& field) { field("list", in_place(self.list)); }
};

inline std::vector<Island>& islands_of(World& world) { return world.memory.of<Islands>().list; }
inline const std::vector<Island>& islands_of(const World& world) {
  return world.memory.of<Islands>().list;
}

/// A moment of a step: `done` (s) of its `h` have passed.
struct Clock {
  Real start = 0, h = 0, done = 0;
  Real now() const { return start + done; }
  Real left() const { return h - done; }
};

void compile(World& world, std::span<const IslandPlan> plans);
void prepare(World& world);
/// The outline, and the load on it in this step.
modes::Part part_of(const World& world, const Island& m);
/// Fills in the current fingers; returns the time (s) until which their velocities are constant.
Real find_fingers(const World& world, Island& m, const Clock& clock);
/// Takes the rest of the step by planar dynamics; returns to modes once one agrees with it for long
/// enough.
void step_dynamics(World& world, Island& m, const Clock& clock);
/// A step of the island.
void step(World& world, Island& m, Real h);

}  // namespace pantin::detail::quasistatic

// Copying, hashing and saving them is compiled once, in row.cpp.
namespace pantin::detail {
extern template quasistatic::Islands& Memories::create();
extern template const quasistatic::Islands& Memories::none();
}  // namespace pantin::detail
