#pragma once
/// A path that oscillates about a centre.
#include "engine/base/fields.hpp"
#include "engine/world/paths/path.hpp"

namespace pantin {

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

  static constexpr std::string_view name = "lissajous";
  static constexpr std::string_view about =
      "A Lissajous curve about a centre: per axis amplitude sin(2 pi frequency t + phase).";
  static constexpr bool turns_smoothly = true;

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
  static void scene_keys(auto& self, auto&& key) {
    using namespace detail;
    using enum PathForm;
    constexpr Real kDegree = kPi / 180;
    self.centre.position = Vec3(kLeftOpen);
    key({"centre", "m",
         "Default: such that the curve passes at time 0 through the initial position of the body."},
        self.centre.position);
    key({"amplitude", "m", "Along x, y and z. Default 0."}, self.amplitude);
    key({"frequency", "Hz", "Along x, y and z, or of all three. Default 0.", vector_or_number},
        self.frequency);
    key({"phase_deg", "degrees", "Likewise. Default 0.", vector_or_number, kDegree}, self.phase);
    key({"rotation_deg", "degrees", "Amplitude of the rotation about x, y and z. Default 0.",
         angles, kDegree, "turn_deg"},
        self.turn_amplitude);
    self.turn_frequency = self.frequency;
    key({"rotation_frequency", "Hz", "Default: as frequency.", vector_or_number, 1,
         "turn_frequency"},
        self.turn_frequency);
    key({"rotation_phase_deg", "degrees", "Of the rotation. Default 0.", vector_or_number, kDegree,
         "turn_phase_deg"},
        self.turn_phase);
    key({"rise", "s",
         "Time over which the motion grows from 0; the body then starts at the centre. Default 0.",
         not_negative},
        self.rise);
  }

  Pose at(Real time) const;
  void move(const Pose& by);
  /// The rise is not shifted.
  void shift(Real ahead);
  void start_from(const Pose& start);
  detail::PathBounds bounds() const;
};

}  // namespace pantin
