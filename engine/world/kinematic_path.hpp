#pragma once
/// Paths of kinematic bodies: key poses or a Lissajous curve.
#include <variant>
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/base/math.hpp"

namespace pantin {

struct Keyframe {
  Real time = 0;  // s
  Pose pose;      // of the body's mass-centre frame

  static void fields(auto& self, auto&& field) {
    field("time", self.time);
    field("pose", self.pose);
  }
};

/// Interpolates the key poses: Catmull-Rom in position, slerp in rotation. Before the first and
/// after the last key the body rests. With `loop` the last key repeats the first one, and the path
/// is periodic for all times.
struct Keyframes {
  std::vector<Keyframe> keys;  // times strictly increasing
  bool loop = false;

  static void fields(auto& self, auto&& field) {
    field("keys", self.keys);
    field("loop", self.loop);
  }
};

/// A Lissajous curve about `centre`: per axis amplitude sin(2 pi frequency t + phase), along the
/// directions of `axes`. The rotation follows the same law as a rotation vector about `axes`.
/// During the first `rise` seconds the amplitude grows smoothly from zero, so that a body at rest
/// starts without a jerk.
struct Lissajous {
  Pose centre;
  Vec3 amplitude{0};       // m
  Vec3 frequency{0};       // Hz
  Vec3 phase{0};           // rad
  Vec3 turn_amplitude{0};  // rad
  Vec3 turn_frequency{0};  // Hz
  Vec3 turn_phase{0};      // rad
  Real rise = 0;           // s
  Quat axes{1, 0, 0, 0};   // from the curve's axes to world axes

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre);
    field("amplitude", self.amplitude);
    field("frequency", self.frequency);
    field("phase", self.phase);
    field("turn_amplitude", self.turn_amplitude);
    field("turn_frequency", self.turn_frequency);
    field("turn_phase", self.turn_phase);
    field("rise", self.rise);
    field("axes", self.axes);
  }
};

/// A component of kinematic bodies. Without it the caller moves the body.
struct KinematicPath {
  std::variant<Keyframes, Lissajous> curve;

  static void fields(auto& self, auto&& field) { field("curve", self.curve); }
};

/// The pose on the path at `time` (s). A path without keys stays at the world's origin.
Pose pose_at(const KinematicPath& path, Real time);

/// The path transformed by a rigid motion of the world.
KinematicPath moved(const KinematicPath& path, const Pose& by);

/// The path shifted in time by `ahead` seconds; the rise of a Lissajous curve keeps its time.
KinematicPath shifted(const KinematicPath& path, Real ahead);

}  // namespace pantin
