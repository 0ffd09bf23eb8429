#pragma once
// Step times of scenes: what `pantin bench` measures, compares and keeps.
#include <nlohmann/json.hpp>

#include "tools/pantin/program.hpp"

namespace pantin::program {

struct BenchChoices {
  std::vector<std::string> scenes;
  SceneChoices how;
  std::string csv, history, against;
  std::optional<int> repeat;
  int threads = 1;
  bool json = false;
};

/// Appends a line for each row to a CSV file, which it begins if there is none. An error: the file
/// has other columns.
Result<Done> append_history(const std::string& path, const Json& head, const Json& rows);

/// The shift of paired differences: the Hodges-Lehmann estimate, with the interval that holds at
/// least 99 % by the exact distribution of Wilcoxon's signed ranks.
struct Shift {
  double least = 0, middle = 0, most = 0;
};
/// Fewer pairs have no interval of 99 %.
inline constexpr int kFewestPairs = 8;
Shift shift_of(const std::vector<double>& differences);

/// Times this program and another one in turns on each scene; prints a verdict for each.
int bench_against(const BenchChoices& choices);

}  // namespace pantin::program
