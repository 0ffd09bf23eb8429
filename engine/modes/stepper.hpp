#pragma once
/// Moves a lamina as its fingers move, quasi-statically: in one contact mode until it ends.
#include "engine/modes/feasible.hpp"
#include "engine/modes/touch.hpp"

namespace pantin::detail::modes {

/// Why a step ended.
enum class Ending : std::uint8_t {
  done,
  no_mode,      // StepEnd::verdict tells why: dynamics must go on from here
  free_motion,  // the modes that hold leave the motion open
  at_corner,    // a point finger is at a convex corner, where it has no normal
  crowded       // more than kMostContacts contacts
};
const char* word_for(Ending ending);

struct StepEnd {
  Ending ending = Ending::done;
  Verdict verdict = Verdict::unique;  // where the step began, or ended early
  Real time = 0;                      // s, how far it came
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
};

/// Copying it is a snapshot. Steps take no memory after the first ones.
class Stepper {
 public:
  Placement placed;
  Motion motion;  // of the last stretch, as at its start

  /// Moves on by `duration` (s), or as far as there is an answer. A mode is kept as long as it
  /// holds; of several others it is the one of index +1 that is farthest from its bounds. Ends of
  /// modes are found to 1e-12 of the step.
  StepEnd step(const Part& part, std::span<const Finger> fingers, Real duration);

 private:
  bool choose(const Moment& now, StepEnd& end);
  bool take(const Moment& now, const Region& r);
  bool take(const Moment& now, const SignedMode& mode);
  void prepare_at(const Moment& now);
  bool find_twist(const Moment& now, Vec3& twist) const;
  bool advance(Moment& now, Real h) const;
  void close(Moment& now) const;
  bool holds(const Moment& now);
  bool stays(const Moment& before, const Moment& now) const;
  void sharpen(const Moment& start, Moment& low, Moment& high, Real sharp);
  Real go(Moment& now, Real longest, Real sharp);

  std::array<Contact, kMostContacts> contacts_;
  std::array<Real, kMostContacts> roll_{}, slide_{};
  Prepared prepared_;
  ModeSet modes_;
  Real tolerance_ = 0;  // m
};

}  // namespace pantin::detail::modes
