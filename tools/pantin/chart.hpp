#pragma once
// Cost against error of a scene, for every way to run it: what `pantin chart` measures and writes.
#include <nlohmann/json.hpp>

#include "tools/pantin/journal.hpp"
#include "tools/pantin/measure.hpp"

namespace pantin::program {

struct ChartChoices {
  std::vector<std::string> scenes, methods;
  std::string out = "out/chart", against, peers;
  std::optional<double> coarsest, duration;  // s
  double time = 60;                          // s, for each scene
  int rungs = 6, repeat = 3;
  bool json = false, afresh = false;
};

/// Measures one scene; results are kept in the journal. The rows are empty if the command was
/// interrupted.
Result<Json> chart_scene(const std::string& path, const ChartChoices& choices, Journal& journal);

/// Marks with "front": true the runs to which no other is superior in both cost and the error of
/// that key. Errors below `floor`, m, count as equal.
void mark_front(Json& runs, double floor, const std::string& error_key);

/// Runs of other engines on a scene, from a file of tools/peers/motion; those of other scenes in it
/// are left out.
Result<Json> read_peers(const std::string& path, const std::string& scene);
/// Adds them to a scene as "peers". The front is then that of all, by the errors of origins alone:
/// no others are known of them.
void add_peers(Json& scene, Json peers);

/// The runs of all scenes as CSV.
std::string chart_csv(const Json& chart);
/// A table of the best runs of a scene, and of those that failed.
void print_chart(const Json& scene);

}  // namespace pantin::program
