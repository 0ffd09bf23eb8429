// What `pantin chart` writes: rows, and a table for the terminal.
#include <fmt/format.h>
#include <fmt/ranges.h>  // join, since fmt 11

#include <algorithm>

#include "engine/base/utf8.hpp"
#include "tools/pantin/chart.hpp"

namespace pantin::program {
namespace {

constexpr const char* kColumns[] = {
    "method",     "step_s",          "tolerance",      "status",       "ended_at_s",
    "follows_s",  "cost_ns",         "cost_low_ns",    "cost_high_ns", "rounds",
    "position_m", "orientation_rad", "joints_m",       "energy_j",     "depth_m",
    "front",      "steps",           "factorisations", "iterations",   "substeps",
    "sweeps",     "unsolved_steps",  "rescued_steps",  "findings",     "reason",
    "origin_m"};

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string all = "\"";
  for (const char c : text) all += c == '"' ? "\"\"" : std::string(1, c);
  return all + '"';
}

std::string cell(const Json& value) {
  if (value.is_null()) return {};
  if (value.is_string()) return quoted(value.get<std::string>());
  if (!value.is_array()) return value.dump();
  std::vector<std::string> words;
  for (const Json& word : value) words.push_back(word.get<std::string>());
  return quoted(fmt::format("{}", fmt::join(words, " ")));
}

/// "1.67e-02", or "-".
std::string short_number(const Json& value) {
  return value.is_number() ? fmt::format("{:.2e}", value.get<double>()) : "-";
}

std::string setting(const Json& run) {
  return run["tolerance"].is_number()
             ? fmt::format("tolerance {:.0e}", run["tolerance"].get<double>())
             : fmt::format("{:.4g} ms", 1e3 * run["step_s"].get<double>());
}

void print_reference(const Json& scene) {
  const Json& r = scene["reference"];
  const double horizon = r["horizon_s"].get<double>();
  if (horizon <= 0) {
    fmt::print("  no reference: {}; errors are unknown\n",
               r["tried"].empty()
                   ? "the time was too short for two runs of any method; repeat with "
                     "a longer --time"
                   : "no method agrees with itself");
    return;
  }
  const std::string confirmed =
      r["confirmed_m"].is_number()
          ? fmt::format("; {} comes within {:.1e} m", r["confirmed_by"].get<std::string>(),
                        r["confirmed_m"].get<double>())
          : "";
  const double step = r["step_s"].get<double>();
  const std::string own = r["position_m"].is_number()
                              ? fmt::format("{:.1e} m", r["position_m"].get<double>())
                              : "unknown";
  fmt::print("  reference   {}{}, own error {}{}\n", printable(r["method"].get<std::string>()),
             step > 0 ? fmt::format(", steps of {:.3g} ms", 1e3 * step) : "", own, confirmed);
  if (!r["whole"].get<bool>())
    fmt::print(
        "              agrees with itself for the first {:.3g} s of {:.3g} s: errors are those of "
        "the "
        "first {:.3g} s\n",
        horizon, scene["duration_s"].get<double>(), r["compared_s"].get<double>());
  if (r["unseen_event_s"].is_number())
    fmt::print("              they do not tell of the event at {:.3g} s and what follows it\n",
               r["unseen_event_s"].get<double>());
}

}  // namespace

std::string chart_csv(const Json& chart) {
  std::string text;
  for (const auto& [key, value] : chart.items())
    if (!value.is_structured())
      text += fmt::format("# {}: {}\n", key,
                          value.is_string() ? value.get<std::string>() : value.dump());
  text += fmt::format("scene,{}\n", fmt::join(kColumns, ","));
  for (const Json& scene : chart["scenes"]) {
    for (const char* list : {"runs", "peers"})
      for (const Json& run : scene.value(list, Json::array())) {
        text += quoted(scene["scene"].get<std::string>());
        for (const char* column : kColumns)
          text += "," + (run.contains(column) ? cell(run[column]) : "");
        text += '\n';
      }
    for (const Json& one : scene["refused"]) {
      text += quoted(scene["scene"].get<std::string>());
      for (const std::string_view column : kColumns)
        text += "," + (column == "status"     ? "refused"
                       : one.contains(column) ? cell(one[column])
                                              : "");
      text += '\n';
    }
  }
  return text;
}

void print_chart(const Json& scene) {
  fmt::print("{}\n", bold(fmt::format("{}: {} bodies, {:.3g} s", scene["scene"].get<std::string>(),
                                      scene["bodies"].get<std::size_t>(),
                                      scene["duration_s"].get<double>())));
  print_reference(scene);
  std::vector<const Json*> front;
  std::map<std::string, std::vector<std::string>> failed;
  std::size_t unrun = 0;
  static const Json kNone = Json::array();
  const Json& peers = scene.contains("peers") ? scene["peers"] : kNone;
  for (const Json& peer : peers)
    if (peer["front"].get<bool>()) front.push_back(&peer);
  for (const Json& run : scene["runs"]) {
    if (run["front"].get<bool>()) front.push_back(&run);
    if (run["status"] == "not_run")
      ++unrun;
    else if (run["status"] != "ok")
      failed[fmt::format("{}: {}", run["method"].get<std::string>(),
                         run["status"].get<std::string>())]
          .push_back(setting(run));
  }
  std::sort(front.begin(), front.end(), [](const Json* a, const Json* b) {
    return (*a)["cost_ns"].get<double>() < (*b)["cost_ns"].get<double>();
  });
  const double real = scene["real_time_ns"].get<double>();
  fmt::print("  {:<28} {:<18} {:>12} {:>7} {:>10} {:>10} {:>10}\n", "best choices", "step",
             "ns/body/s", "+-", "of a core", "error m", "joints m");
  for (const Json* run : front) {
    const double cost = (*run)["cost_ns"].get<double>();
    const double spread =
        50 * ((*run)["cost_high_ns"].get<double>() - (*run)["cost_low_ns"].get<double>()) / cost;
    const bool known = (*run)["rounds"].get<int>() > 1;
    fmt::print("  {:<28} {:<18} {:>12.0f} {:>7} {:>8.2g} % {:>10} {:>10}\n",
               (*run)["method"].get<std::string>(), setting(*run), cost,
               known ? fmt::format("{:.0f} %", spread) : "-", 100 * cost / real,
               short_number((*run)["position_m"]), short_number((*run)["joints_m"]));
  }
  for (const auto& [what, settings] : failed)
    fmt::print("  failed      {} at {}\n", what, fmt::join(settings, ", "));
  for (const Json& one : scene["refused"])
    fmt::print("  refused     {}: {}\n", one["method"].get<std::string>(),
               printable(one["reason"].get<std::string>()));
  if (unrun > 0)
    fmt::print("  not run     {} runs: the time was over; repeat with a longer --time\n", unrun);
}

}  // namespace pantin::program
