#pragma once
/// Moves a lamina as its fingers move, quasi-statically: in one contact mode until it ends.
#include <limits>

#include "engine/modes/feasible.hpp"
#include "engine/modes/touch.hpp"

namespace pantin::detail::modes {

/// Why a step ended.
enum class Ending : std::uint8_t {
  done,
  no_mode,      // StepEnd::verdict says why: dynamics must continue from here
  free_motion,  // the modes that hold leave the motion open
  at_corner,    // a point finger is at a convex corner, where it has no normal
  crowded,      // more than kMostContacts contacts
  undecided,    // of several modes, none is the only one that is stable: see Doubt
  zeno          // modes switch faster than can be followed: likewise
};
const char* word_for(Ending ending);

/// What to do where quasi-statics leaves the motion open: several modes hold, of which none was the
/// last one, or modes switch without end.
enum class Doubt : std::uint8_t {
  decide,  // the stable mode (index +1) of the largest margin; modes alternate
  stop     // unless one mode alone is stable
};

struct StepEnd {
  Ending ending = Ending::done;
  Verdict verdict = Verdict::unique;  // where the step began, or ended early
  Real time = 0;                      // s, reached
  int switches = 0;                   // of the mode
  bool zeno = false;                  // they came faster than can be followed
  std::size_t choices = 0;            // most modes that held at once
};

/// The mode that the lamina moves in.
struct Motion {
  Touches touches;
  Signs signs;    // of the touches
  Vec3 twist{0};  // about the scene's origin
  int index = 0;  // see index_of; 0 where forces are not unique
  std::array<Real, kMostContacts> normal_force{}, tangent_force{};  // of the touches, N
  bool is_known = false;

  static void fields(auto& self, auto&& field) {
    field("touches", self.touches);
    field("signs", self.signs);
    field("twist", passive(self.twist));
    field("index", self.index);
    field("normal_force", passive(self.normal_force));
    field("tangent_force", passive(self.tangent_force));
    field("is_known", self.is_known);
  }
};

/// A pose and motion of a lamina that were not found by modes: see Stepper::resume().
struct Found {
  Placement placed;
  Vec3 twist{0};   // about the scene's origin
  Real apart = 0;  // m/s: how far from it a mode's motion may be, anywhere on the outline
  std::uint32_t fingers = UINT32_MAX;  // those that touch, a bit each
};

/// Whether a mode holds, and its margin.
struct Slack {
  bool holds = false;
  Real value = std::numeric_limits<Real>::quiet_NaN();  // below 0 where it does not; NaN: unknown
};

/// A copy is a snapshot. Steps allocate nothing after the first ones.
class Stepper {
 public:
  Placement placed;
  Motion motion;  // of the last stretch, as at its start
  Doubt doubt = Doubt::decide;

  /// Advances by `duration` (s), or until no mode is found. A mode is kept as long as it holds;
  /// then the one of index +1 with the largest margin follows. Ends of modes are located to 1e-12
  /// of the step.
  StepEnd step(const Part& part, std::span<const Finger> fingers, Real duration);

  /// Continues from a given motion, in the stable mode whose motion is most similar. The lamina is
  /// moved so that contacts of these fingers within 1 % of the outline's extent are closed. False,
  /// without effect, if no stable mode is similar enough.
  bool resume(const Part& part, std::span<const Finger> fingers, const Found& found);

  /// Reserves memory for steps with this many contacts.
  void reserve(std::size_t contacts);

 private:
  bool choose(const Moment& now, StepEnd& end);
  bool take(const Moment& now, const Region& r);
  bool take(const Moment& now, const SignedMode& mode);
  bool take_nearest(const Moment& now, const Found& found);
  void prepare_at(const Moment& now);
  bool find_twist(const Moment& now, Vec3& twist) const;
  bool advance(Moment& now, Real h) const;
  void close(Moment& now) const;
  Slack forces_hold(const Moment& now);
  Slack contacts_stay(const Moment& before, const Moment& now) const;
  Slack holds(const Moment& before, const Moment& now);
  void sharpen(const Moment& start, Moment& low, Moment& high, Real sharp);
  Real go(Moment& now, Real longest, Real sharp);

  std::array<Contact, kMostContacts> contacts_;
  std::array<Real, kMostContacts> roll_{}, slide_{};
  Prepared prepared_;
  ModeSet modes_;
  Real tolerance_ = 0;  // m
};

}  // namespace pantin::detail::modes
