#pragma once
/// How a driven body moves: by key poses or along a Lissajous curve.
#include <variant>
#include <vector>

#include "engine/base/math.hpp"

namespace pantin {

struct Keyframe {
  Real time = 0;  // s
  Pose pose;      // of the body's mass-centre frame
};

/// Passes through every key pose: Catmull-Rom in position, slerp in rotation. Before the first and
/// after the last key the body rests there, unless `loop` joins the last to the first.
struct Keyframes {
  std::vector<Keyframe> keys;  // times strictly increasing
  bool loop = false;
};

/// centre + amplitude sin(2 pi frequency t + phase), axis by axis; the turn likewise about the
/// centre's axes, as a rotation vector.
struct Lissajous {
  Pose centre;
  Vec3 amplitude{0};       // m
  Vec3 frequency{0};       // Hz
  Vec3 phase{0};           // rad
  Vec3 turn_amplitude{0};  // rad
  Vec3 turn_frequency{0};  // Hz
  Vec3 turn_phase{0};      // rad
};

/// A component of driven bodies. A driven body without one is moved by live calls.
struct Drive {
  std::variant<Keyframes, Lissajous> path;
};

/// Where the path is at `time` (s).
Pose pose_at(const Drive& drive, Real time);

}  // namespace pantin
