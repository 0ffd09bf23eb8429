#pragma once
// The hand of the viewer: what it has picked, where that is to go, and what came of it.
#include <optional>
#include <string>
#include <vector>

#include "tools/pantin/view_pick.hpp"

namespace pantin::program {

using namespace detail;

/// One drag, from the press of a button to its release.
struct Drag {
  std::string body, grip;      // grip: exact, spring or kinematic
  double at = 0, held = 0;     // s, simulated: when it began and how long it lasted
  double distance_moved = 0;   // m, of the picked point, from start to end
  double residual = 0;         // m, of the picked point from its target at the end
  double worst_residual = 0;   // m, after any step while held
  double worst_elsewhere = 0;  // m, of any other held point while this one was held
  bool reachable = true;       // false: the links were too short at the end
};

/// Drags one body at a time. A dynamic body is held by a pin that goes before all others; a
/// kinematic one is carried itself, its Drive taken away, and led back to its path after the
/// release.
class Hand {
 public:
  bool holds() const { return static_cast<bool>(body_); }
  /// The drag at hand.
  const Drag& now() const { return now_; }

  /// Picks. The point follows the pixel in the plane that faces the eye.
  void take(World& world, const Picked& picked, PinKind grip, const SeenPixel& mouse);
  /// The mouse moved.
  void move(const SeenPixel& mouse);
  /// The camera moved: the target stays where it is.
  void look_again(const SeenPixel& mouse);
  /// The button is up.
  void let_go(World& world);
  /// The World was replaced by one that this hand never touched.
  void forget();

  /// What is due of the way to the target is spread over the next `parts` calls of before_part.
  void expect(int parts) { parts_left_ = parts; }
  /// At Place::before_drive, once a substep of `h` seconds.
  void before_part(World& world, Real h);
  /// At Place::after_step.
  void after_step(const World& world);

  /// Every drag that has ended.
  const std::vector<Drag>& drags() const { return drags_; }

 private:
  /// A kinematic body that is not on its path.
  struct Away {
    Entity body;
    std::optional<KinematicPath> drive;
    Pose left;       // where it was let go
    Real since = 0;  // s, when
    bool is_held = true;
  };
  void take_kinematic(World& world);
  void lead_back(World& world, Real h);
  Vec3 grip_point(const World& world) const;

  Entity body_, pin_;
  Vec3 anchor_{0};             // of the picked point, in the mass-centre frame
  Vec3 target_{0}, goal_{0};   // world: for the step at hand, and where the mouse is
  Vec3 plane_{0}, offset_{0};  // a point of the plane; from the mouse's point to the goal
  Vec3 start_{0};              // where the picked point was
  int parts_left_ = 1;
  Drag now_;
  std::vector<Away> away_;
  std::vector<Drag> drags_;
};

}  // namespace pantin::program
