#pragma once
/// A path through key poses.
#include <vector>

#include "engine/base/fields.hpp"
#include "engine/world/paths/path.hpp"

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

  static constexpr std::string_view name = "keyframes";
  static constexpr std::string_view about =
      "Poses in order of time: Catmull-Rom interpolation of position, slerp of rotation. The body "
      "rests before the first and after the last.";
  static constexpr bool turns_smoothly = false;

  static void fields(auto& self, auto&& field) {
    field("keys", self.keys);
    field("loop", self.loop);
  }

  /// The pose at `time`; without keys the world's origin.
  Pose at(Real time) const;
  void move(const Pose& by);
  void shift(Real ahead);
  void start_from(const Pose& start);
  detail::PathBounds bounds() const;
  std::size_t parts() const { return keys.size(); }
  Pose seam() const;
};

}  // namespace pantin
