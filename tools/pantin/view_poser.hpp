#pragma once
// Pose mode of the viewer: a mechanism follows the mouse without dynamics.
#include <pantin/assembler.hpp>
#include <string>
#include <vector>

#include "engine/world/world.hpp"

namespace pantin::program {

using namespace detail;

/// What a drag in pose mode keeps of the body.
enum class PoseGrip : std::uint8_t {
  point,    // its point under the mouse follows; it may rotate
  rotation  // the same, and its rotation in the world is kept
};

/// A point of a body that follows the mouse.
struct PosedPoint {
  Entity body;
  Vec3 anchor{0};  // in the mass-centre frame
  Vec3 target{0};  // world, m
  PoseGrip grip = PoseGrip::point;
};

/// Why a World has no pose mode, or an empty text.
std::string pose_fault(const World& world);

/// Bodies that follow one point while joints, pins, limits and surfaces in contact hold. Other pins
/// of the World are held, too. Elastic cables that are hardly stretched at the start count as
/// inextensible. Collisions are not considered.
class Poser {
 public:
  explicit Poser(const World& world);

  /// The World has changed otherwise.
  void renew(const World& world);
  /// Drags a dynamic body.
  void take(const World& world, const PosedPoint& point);
  void move(Vec3 target);
  void let_go();
  /// Several iterations towards the target, and writes the poses.
  void follow(World& world);

  /// Whether poses differ from those at the start.
  bool has_moved() const { return has_moved_; }
  void note_motion() { has_moved_ = true; }
  /// m or rad, the largest of all laws after the last iteration.
  Real joint_error() const { return joint_error_; }

 private:
  void add_target(const World& world);
  Vec3 target_of_frame() const;

  std::vector<Entity> stiff_;  // elastic cables that count as inextensible
  Assembler assembler_;
  PosedPoint point_;
  Target target_;
  Vec3 offset_{0};  // world: from the point to the origin of the frame, if the rotation is kept
  bool holds_ = false, has_moved_ = false;
  Real joint_error_ = 0;
};

/// The state after pose mode: all dynamic bodies at rest at their present poses, and no memory of
/// the motion before. Contacts of surface joints are found again.
World at_rest(const World& world);

}  // namespace pantin::program
