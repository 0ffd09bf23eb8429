#pragma once
/// Measures of a motion, all of poses and velocities alone: the same ruler for every engine.
#include <string>
#include <vector>

#include "tools/peers/bodies/motion.hpp"
#include "tools/peers/bodies/plain.hpp"

namespace pantin::peers {

/// What "at rest" looks back over, s.
inline constexpr double kRest = 0.5;

struct Verdict {
  std::vector<std::pair<std::string, std::string>> told;  // by the engine, of itself
  int frames = 0;
  double median_ms = 0, p99_ms = 0, most_ms = 0, mean_ms = 0;
  double opening = 0, opening_at_rest = 0;  // m, of joints and exact pins; at rest: see kRest
  double turn = 0, turn_at_rest = 0;        // rad, of joints beyond their kinds and limits
  double stretch = 0;                       // m, of cables beyond their length
  // m, of bodies that may touch, in one another. `depth` leaves out pairs that start so, until they
  // have been apart.
  double depth = 0, depth_at_rest = 0, depth_at_start = 0;
  double energy = 0;   // J at the end, less that at the start
  double gained = 0;   // J, the most above the start at any time, or 0
  double kinetic = 0;  // J at the end
  double moved = 0;    // m, the farthest any body was from its last place
                       // within the last second
  int lost = 0;  // bodies not finite, wholly below a fixed plane, or 100 m from where they started
  int bodies = 0;            // dynamic
  double asleep_after = -1;  // s, from when on all slept; below zero: never
};

/// Of the file that an engine wrote about `scene`, whose World is compiled and at its start. False:
/// the file cannot be read or is of another scene.
bool judge(const World& start, const std::string& file, Verdict& verdict);

}  // namespace pantin::peers
