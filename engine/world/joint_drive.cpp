#include "engine/world/joint_drive.hpp"

#include <algorithm>

namespace pantin {

using namespace detail;

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
