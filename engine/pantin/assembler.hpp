#pragma once
/// Assembly and inverse kinematics: bodies at poses where all joints, limits and other laws hold,
/// without dynamics.
///
/// `assemble` brings parts together once, from anywhere. An Assembler follows targets, as for a
/// hand that drags a mechanism or a figure whose hands and feet are led:
///
///   Assembler figure(world);
///   const Target hand = must(figure.add(PointTarget{.body = palm, .target = {0.4, 1.2, 0}}));
///   for (;;) {
///     figure.move(hand, mouse_position());
///     figure.iterate();                      // one Gauss-Newton step, without allocation
///     draw(figure.world());
///   }
///
/// Joints come first: targets that cannot be reached, or that contradict one another, are met as
/// nearly as the laws allow, in the sense of weighted least squares.
#include <cstdint>
#include <memory>
#include <pantin/world.hpp>
#include <string>
#include <vector>

#include "engine/base/result.hpp"

namespace pantin {

/// Result of `assemble`. Laws are joints, pins, gears, belts, cables and surface joints.
struct Assembly {
  bool assembled = false;
  Real residual = 0;                  // the largest of all laws, m or rad
  int iterations = 0;                 // of all starts
  int starts = 0;                     // perturbed starts that were tried after the first
  int mobility = 0;                   // degrees of freedom that are left
  std::vector<Entity> redundant;      // laws with rows that follow from others
  std::vector<Entity> contradictory;  // laws that cannot hold together; without any one they can
  std::vector<Real> lengths;          // of those that are free, m, in their order; 0: none
};

/// A distance joint or an inextensible cable whose length `assemble` may change.
struct FreeLength {
  Entity law = {};
  Real least = 1e-9, most = 1e9;  // m
};

/// Moves the bodies to a configuration near their poses at which all laws hold to `tolerance` (m or
/// rad); fixed and kinematic bodies and those `held` stay. If that is impossible the bodies end in
/// the pose of least squares. The result depends on nothing but the World.
///
/// Lengths that are `free` change too, as little as possible relative to their size: the least sum
/// of squares of all closures nearby. A linkage whose parts do not fit gets the lengths that fit.
Assembly assemble(World& world, const std::vector<Entity>& held = {}, Real tolerance = 1e-12,
                  const std::vector<FreeLength>& free = {});

/// A point of a body, in the frame the body was placed by, that should be at a point of the world.
struct PointTarget {
  Entity body = {};
  Vec3 point{0};    // m
  Vec3 target{0};   // world, m
  Real weight = 1;  // relative to other targets
};

/// The frame that a body was placed by, which should be at a frame of the world.
struct PoseTarget {
  Entity body = {};
  Pose target = {};
  Real weight = 1, turn_weight = 1;  // of its position, and of its rotation
};

/// A line of a body, in the frame the body was placed by, that should pass through a point of the
/// world: a head that looks at something, an arm that points there.
struct AimTarget {
  Entity body = {};
  Vec3 point{0};            // of the line, m
  Vec3 direction{1, 0, 0};  // along it; of any length
  Vec3 target{0};           // world, m
  Real weight = 1;
};

/// A target of an Assembler, by its number.
struct Target {
  std::uint32_t number = UINT32_MAX;
};

/// Errors after one iteration, the largest of each sort, m or rad.
struct AssemblerErrors {
  Real joints = 0;   // of all laws and limits
  Real targets = 0;  // distances from the targets
};

/// Bodies that follow targets. Holds a copy of a World. A copy of an Assembler goes on with the
/// same bits; one that is made of its World starts anew there.
class Assembler {
 public:
  /// Starts at the poses of `world`.
  explicit Assembler(const World& world);
  ~Assembler();
  Assembler(const Assembler&);
  Assembler& operator=(const Assembler&);
  Assembler(Assembler&&) noexcept;
  Assembler& operator=(Assembler&&) noexcept;

  /// Adds a target. An error names a body that does not exist or cannot move, or a bad number.
  [[nodiscard]] Result<Target> add(const PointTarget& target);
  [[nodiscard]] Result<Target> add(const PoseTarget& target);
  [[nodiscard]] Result<Target> add(const AimTarget& target);
  /// Moves the point of a target, or the position of a pose. Returns false, and does nothing, if
  /// there is no such target or a number is not finite.
  bool move(Target target, Vec3 to);
  /// Moves a pose.
  bool move(Target target, const Pose& to);
  bool set_weight(Target target, Real weight);
  void remove(Target target);
  /// Keeps a body where it is, as the feet of a figure.
  void hold(Entity body);
  void let_go(Entity body);

  /// One damped Gauss-Newton step of all bodies. Allocates only after targets were added or
  /// removed, or bodies held.
  AssemblerErrors iterate();
  /// Iterates until the poses settle, at most `iterations` times.
  AssemblerErrors settle(int iterations = 200);

  /// The World with the present poses.
  const World& world();
  /// Writes the poses to a World with the same bodies.
  void write_to(World& world) const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace pantin
