#include "engine/world/drive_motion.hpp"

#include <cmath>

namespace pantin::detail {

bool is_sound(const DriveMotion& motion) {
  for (const Real x :
       {motion.offset, motion.speed, motion.amplitude, motion.frequency, motion.phase})
    if (!std::isfinite(x)) return false;
  for (std::size_t i = 0; i < motion.knots.size(); ++i) {
    const MotionKnot& knot = motion.knots[i];
    if (!std::isfinite(knot.time) || !std::isfinite(knot.value)) return false;
    if (i > 0 && !(knot.time > motion.knots[i - 1].time)) return false;
  }
  return true;
}

void delay(DriveMotion& motion, Real by) {
  motion.offset -= motion.speed * by;
  motion.phase -= 2 * kPi * motion.frequency * by;
  for (MotionKnot& knot : motion.knots) knot.time += by;
}

void scale(DriveMotion& motion, Real factor) {
  for (Real* x : {&motion.offset, &motion.speed, &motion.amplitude}) *x *= factor;
  for (MotionKnot& knot : motion.knots) knot.value *= factor, knot.rate *= factor;
}

}  // namespace pantin::detail
