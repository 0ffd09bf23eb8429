#pragma once
/// A rigid body and the forces on it.
#include <cstdint>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

enum class Motion : std::uint8_t {
  dynamic,    // moved by forces and joints
  fixed,      // never moves
  kinematic,  // moved along a KinematicPath or by the caller; joints follow it
};
constexpr Motion last_of(Motion) { return Motion::kinematic; }

/// A rigid body in its mass-centre frame.
///
/// `pose` places the frame of principal axes at the mass centre. Anchors, shapes and `inertia` are
/// given in that frame. A scene file may place a body by another frame of its own: see
/// World::origins. After changing `pose`, `velocity` or `angular_velocity` of a dynamic body set
/// `restart`; after changing `mass`, `inertia` or `motion` call World::mark_dirty().
struct Body {
  Pose pose;
  Vec3 velocity{0};          // of the mass centre, m/s
  Vec3 angular_velocity{0};  // angular velocity, world axes, rad/s
  Motion motion = Motion::dynamic;
  bool restart = false;   // the caller changed the motion: the integrator restarts from here
  bool teleport = false;  // the pose jumped: no interpolation from the old pose
  Real mass = 1;          // kg
  Vec3 inertia{1};        // principal moments, kg m^2
  Real drag = 0;          // rate c of the damping exp(-c t), 1/s
  Real gravity_scale = 1;

  static void fields(auto& self, auto&& field) {
    field("pose", self.pose);
    field("velocity", self.velocity);
    field("angular_velocity", self.angular_velocity);
    field("motion", self.motion);
    field("restart", self.restart);
    field("teleport", self.teleport);
    field("mass", self.mass);
    field("inertia", self.inertia);
    field("drag", self.drag);
    field("gravity_scale", self.gravity_scale);
  }
};

namespace detail {

/// Velocity of the body's point that is at `at`, in world axes.
inline Vec3 velocity_at(const Body& b, Vec3 at) {
  return b.velocity + glm::cross(b.angular_velocity, at - b.pose.position);
}

/// External force on a body during the next step. World::push() adds to it; each step clears it.
struct Force {
  Vec3 force{0};   // N, world axes, at the mass centre
  Vec3 torque{0};  // N m, world axes

  static void fields(auto& self, auto&& field) {
    field("force", self.force);
    field("torque", self.torque);
  }
};

}  // namespace detail

}  // namespace pantin
