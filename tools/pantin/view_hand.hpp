#pragma once
// Dragging in the viewer: the picked body, its target, and the result.
#include <optional>
#include <string>
#include <vector>

#include "tools/pantin/view_pick.hpp"
#include "tools/pantin/view_poser.hpp"

namespace pantin::program {

using namespace detail;

/// One drag, from the press of a button to its release.
struct Drag {
  std::string body, grip;      // grip: exact, spring, kinematic, pose or pose_rotation
  double at = 0, held = 0;     // s, simulated: start and duration
  double distance_moved = 0;   // m, of the picked point, from start to end
  double residual = 0;         // m, of the picked point to its target at the end
  double worst_residual = 0;   // m, after any step while held
  double worst_elsewhere = 0;  // m, of any other pin while this one was held
  bool reachable = true;       // false: the links were too short at the end
};

/// Drags one body at a time. A dynamic body is held by a pin of the highest priority. A kinematic
/// body is moved directly: its KinematicPath is removed, and restored with a smooth return after
/// the release. In pose mode no time passes, and mechanisms follow without dynamics.
class Hand {
 public:
  bool holds() const { return static_cast<bool>(body_); }
  /// The present drag.
  const Drag& now() const { return now_; }

  /// Picks a body. The point follows the pixel in the plane perpendicular to the view.
  void take(World& world, const Picked& picked, PinKind grip, const SeenPixel& mouse);
  /// The mouse moved.
  void move(const SeenPixel& mouse);
  /// The camera moved: the target stays where it is.
  void look_again(const SeenPixel& mouse);
  /// The button was released.
  void let_go(World& world);
  /// The World was replaced by one without this drag. Ends pose mode.
  void forget();

  /// Begins pose mode.
  void start_posing(const World& world);
  /// Ends it. Returns whether bodies were moved.
  bool stop_posing(World& world);
  bool poses() const { return poser_.has_value(); }
  /// In pose mode, once a picture: bodies follow the mouse.
  void pose(World& world);
  /// In pose mode: the World was changed otherwise.
  void renew(const World& world);

  /// Spreads the remaining motion of the target over the next `parts` calls of before_part.
  void expect(int parts) { parts_left_ = parts; }
  /// Called at Stage::before_drive, once per substep of `h` seconds.
  void before_part(World& world, Real h);
  /// Called at Stage::after_step.
  void after_step(const World& world);

  /// All completed drags.
  const std::vector<Drag>& drags() const { return drags_; }

 private:
  /// A kinematic body that has left its path.
  struct Away {
    Entity body;
    std::optional<KinematicPath> drive;
    Pose left;       // pose at the release
    Real since = 0;  // s, time of the release
    bool is_held = true;
  };
  void take_kinematic(World& world);
  void take_pose(const World& world, PinKind grip);
  void lead_back(World& world, Real h);
  Vec3 grip_point(const World& world) const;

  Entity body_, pin_;
  Vec3 anchor_{0};             // of the picked point, in the mass-centre frame
  Vec3 target_{0}, goal_{0};   // world: for the present step, and of the mouse
  Vec3 plane_{0}, offset_{0};  // a point of the drag plane; offset from the mouse's point to the
                               // goal
  Vec3 start_{0};              // initial position of the picked point
  int parts_left_ = 1;
  std::optional<Poser> poser_;  // in pose mode
  Drag now_;
  std::vector<Away> away_;
  std::vector<Drag> drags_;
};

}  // namespace pantin::program
