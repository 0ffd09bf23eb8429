#include "engine/world/joint_drive.hpp"

#include <algorithm>
#include <cmath>

namespace pantin {

using namespace detail;

namespace {

/// A law between two knots, at the fraction `u` of their interval, by u.
CoordinateMotion shape_of(MotionLaw law, Real u) {
  if (law == MotionLaw::cycloidal) {
    const Real w = 2 * kPi;
    return {u - std::sin(w * u) / w, 1 - std::cos(w * u), w * std::sin(w * u)};
  }
  if (law == MotionLaw::polynomial)
    return {u * u * u * (10 - u * (15 - 6 * u)), 30 * u * u * (1 - u) * (1 - u),
            60 * u * (1 - u) * (1 - 2 * u)};
  return {u, 1, 0};
}

/// From one knot to the next, at a time between them.
CoordinateMotion between(MotionLaw law, const MotionKnot& from, const MotionKnot& to, Real time) {
  const Real length = to.time - from.time, u = (time - from.time) / length,
             rise = to.value - from.value;
  CoordinateMotion at = shape_of(law, u);
  at = {from.value + rise * at.value, rise / length * at.rate,
        rise / (length * length) * at.acceleration};
  if (law != MotionLaw::spline) return at;
  // The cubic of Hermite, as what it adds to the chord.
  const Real a = from.rate - rise / length, b = to.rate - rise / length;
  at.value += length * u * (1 - u) * (a * (1 - u) - b * u);
  at.rate += a * (1 - u) * (1 - 3 * u) - b * u * (2 - 3 * u);
  at.acceleration += (a * (6 * u - 4) + b * (6 * u - 2)) / length;
  return at;
}

CoordinateMotion knots_at(const DriveMotion& motion, Real time) {
  const std::vector<MotionKnot>& knots = motion.knots;
  if (knots.empty()) return {};
  const MotionKnot &first = knots.front(), &last = knots.back();
  const Real length = last.time - first.time;
  Real gone = 0;
  if (motion.loop && length > 0) {
    const Real rounds = std::floor((time - first.time) / length);
    time -= length * rounds, gone = rounds * (last.value - first.value);
  }
  if (time <= first.time && !(motion.loop && length > 0)) return {first.value};
  if (time >= last.time && !(motion.loop && length > 0)) return {last.value};
  auto next = std::upper_bound(knots.begin() + 1, knots.end() - 1, time,
                               [](Real t, const MotionKnot& k) { return t < k.time; });
  CoordinateMotion at = between(motion.law, *(next - 1), *next, time);
  at.value += gone;
  return at;
}

}  // namespace

CoordinateMotion motion_at(const DriveMotion& motion, Real time) {
  CoordinateMotion at = knots_at(motion, time);
  at.value += motion.offset + motion.speed * time, at.rate += motion.speed;
  if (motion.amplitude == 0) return at;
  const Real w = 2 * kPi * motion.frequency, angle = w * time + motion.phase;
  at.value += motion.amplitude * std::sin(angle);
  at.rate += motion.amplitude * w * std::cos(angle);
  at.acceleration -= motion.amplitude * w * w * std::sin(angle);
  return at;
}

// Equal second derivatives at each knot are a tridiagonal system for the rates, cyclic in a loop.
// The iteration converges by a factor of 2 a sweep or faster: each rate has twice the weight of its
// neighbours together.
void fit_spline(DriveMotion& motion) {
  constexpr int kSweeps = 60;
  std::vector<MotionKnot>& knots = motion.knots;
  const std::size_t count = knots.size();
  for (MotionKnot& k : knots) k.rate = 0;
  if (motion.law != MotionLaw::spline || count < 2) return;
  const auto fit = [&](std::size_t before, std::size_t at, std::size_t after) {
    // `before` may be the last knot but one, and `at` the last as well as the first.
    const MotionKnot &from = knots[before], &end = knots[before + 1], &next = knots[after];
    const Real h0 = end.time - from.time, h1 = next.time - knots[after - 1].time;
    const Real s0 = (end.value - from.value) / h0, s1 = (next.value - knots[after - 1].value) / h1;
    knots[at].rate = (3 * (h1 * s0 + h0 * s1) - h1 * from.rate - h0 * next.rate) / (2 * (h0 + h1));
  };
  for (int n = 0; n < kSweeps; ++n) {
    for (std::size_t i = 1; i + 1 < count; ++i) fit(i - 1, i, i + 1);
    if (!motion.loop || count < 3) continue;
    fit(count - 2, 0, 1);
    knots.back().rate = knots.front().rate;
  }
}

Quat target_at(const JointDrive& drive, Real time) {
  const std::vector<PoseKey>& keys = drive.keys;
  if (keys.empty()) return drive.target;
  const Real begin = keys.front().time, length = keys.back().time - begin;
  if (drive.loop && length > 0)
    time = begin + (time - begin) - length * std::floor((time - begin) / length);
  if (time <= begin) return keys.front().rotation;
  if (time >= keys.back().time) return keys.back().rotation;
  const auto next = std::upper_bound(keys.begin(), keys.end(), time,
                                     [](Real t, const PoseKey& k) { return t < k.time; });
  const PoseKey &from = *(next - 1), &to = *next;
  return glm::normalize(
      glm::slerp(from.rotation, to.rotation, (time - from.time) / (to.time - from.time)));
}

}  // namespace pantin
