#pragma once
/// The timing of what was planned.
#include <vector>

#include "tools/peers/measure.hpp"

namespace pantin::peers {

struct Task {
  Point point;
  int repeats = 1;  // of a second in a round
};

double cpu_seconds();

/// CPU ms of one second of motion, the reset not counted.
double time_once(Run& run);

/// One round after the other through all tasks that did not fail, each round in an order and in a
/// process of its own: where code and data lie in memory can cost a method a sixth, and does so all
/// the life of a process. False: a process did not come to its end. `argv`: this program's.
bool time_rounds(int rounds, char** argv, std::vector<Task>& tasks, const Report& report);

/// What such a process does instead: reads tasks from the standard input and prints their CPU ms.
inline constexpr const char* kServe = "--serve";
void serve_round(const std::vector<Peer>& peers);

}  // namespace pantin::peers
