#pragma once
/// How a driven body moves: by key poses or along a Lissajous curve.
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

/// Passes through every key pose: Catmull-Rom in position, slerp in rotation. Before the first and
/// after the last key the body rests there. With `loop` the last key is the first one again: the
/// path is repeated for all times, before the first key too.
struct Keyframes {
  std::vector<Keyframe> keys;  // times strictly increasing
  bool loop = false;

  static void fields(auto& self, auto&& field) {
    field("keys", self.keys);
    field("loop", self.loop);
  }
};

/// A sway about `centre`: axis by axis amplitude sin(2 pi frequency t + phase), in the directions
/// of `axes`; the turn likewise about `axes`, as a rotation vector. During the first `rise` seconds
/// the sway grows smoothly from nothing, so that a body at rest at its centre is not jerked.
struct Lissajous {
  Pose centre;
  Vec3 amplitude{0};       // m
  Vec3 frequency{0};       // Hz
  Vec3 phase{0};           // rad
  Vec3 turn_amplitude{0};  // rad
  Vec3 turn_frequency{0};  // Hz
  Vec3 turn_phase{0};      // rad
  Real rise = 0;           // s
  Quat axes{1, 0, 0, 0};   // from the sway's axes to the world's

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

/// A component of driven bodies. A driven body without one is moved by live calls.
struct Drive {
  std::variant<Keyframes, Lissajous> path;

  static void fields(auto& self, auto&& field) {
    field("path", self.path);
  }
};

/// Where the path is at `time` (s). A path without keys is the world's origin.
Pose pose_at(const Drive& drive, Real time);

/// Moves a whole path by a rigid motion of the world.
Drive moved(const Drive& drive, const Pose& by);

/// The same path run `ahead` seconds earlier; the rise of a sway keeps its time.
Drive hastened(const Drive& drive, Real ahead);

}  // namespace pantin
