// Other engines on a chart: runs that tools/peers/motion measured on the same scene.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>

#include "engine/base/utf8.hpp"
#include "engine/scene/json/text_file.hpp"
#include "tools/pantin/chart.hpp"

namespace pantin::program {
namespace {

constexpr std::size_t kMostBytes = 1u << 26;
constexpr const char* kColumns[] = {"scene",   "engine", "method",       "step_s",
                                    "error_m", "bodies", "cpu_ms_per_s", "status"};
enum Column { scene, engine, method, step, error, bodies, cost, status, columns };

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == ',')
      cells.emplace_back();
    else if (c != '\r')
      cells.back() += c;
  return cells;
}

/// A number, or null for an empty cell; nothing if it is none.
std::optional<Json> number_of(const std::string& cell) {
  if (cell.empty()) return Json(nullptr);
  double x = 0;
  const auto read = std::from_chars(cell.data(), cell.data() + cell.size(), x);
  if (read.ec != std::errc() || read.ptr != cell.data() + cell.size()) return std::nullopt;
  return std::isfinite(x) ? Json(x) : Json(nullptr);
}

/// Where the columns are; an error names one that is missing.
Result<std::vector<std::size_t>> places_of(const std::string& path, const std::string& line) {
  const std::vector<std::string> titles = cells_of(line);
  std::vector<std::size_t> places;
  for (const char* column : kColumns) {
    const auto found = std::ranges::find(titles, column);
    if (found == titles.end())
      return Error{
          fmt::format("{}:1: found no column {}, expected the columns that "
                      "tools/peers/motion writes",
                      path, column)};
    places.push_back(static_cast<std::size_t>(found - titles.begin()));
  }
  return places;
}

/// A run of another engine, with the members of our own.
Result<Json> run_of(const std::vector<std::string>& cells, const std::string& at) {
  const auto h = number_of(cells[step]), e = number_of(cells[error]), c = number_of(cells[cost]),
             n = number_of(cells[bodies]);
  if (!h || !e || !c || !n || !h->is_number() || !n->is_number() || !(n->get<double>() >= 1))
    return Error{at +
                 ": found no number, expected one for each of step_s, error_m, bodies and "
                 "cpu_ms_per_s"};
  Json run{{"method", cells[engine] + " " + cells[method]},
           {"step_s", *h},
           {"tolerance", nullptr},
           {"status", cells[status]},
           {"position_m", *e},
           {"origin_m", *e},
           {"rounds", 1}};
  const Json ns = c->is_number() ? Json(1e6 * c->get<double>() / n->get<double>()) : Json(nullptr);
  for (const char* key : {"cost_ns", "cost_low_ns", "cost_high_ns"}) run[key] = ns;
  run["joints_m"] = nullptr;
  return run;
}

}  // namespace

Result<Json> read_peers(const std::string& path, const std::string& of_scene) {
  Result<std::string> text = detail::read_text(path, kMostBytes, "measurements of other engines");
  if (!text) return text.errors();
  const std::string name = std::filesystem::path(of_scene).stem().string();
  Json runs = Json::array();
  std::optional<std::vector<std::size_t>> places;
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text->size();) {
    const std::size_t end = std::min(text->find('\n', begin), text->size());
    const std::string line = text->substr(begin, end - begin);
    begin = end + 1, ++number;
    if (!places) {
      Result<std::vector<std::size_t>> found = places_of(path, line);
      if (!found) return found.errors();
      places = std::move(*found);
      continue;
    }
    const std::vector<std::string> all = cells_of(line);
    std::vector<std::string> cells(columns);
    for (std::size_t i = 0; i < columns; ++i)
      if ((*places)[i] < all.size()) cells[i] = all[(*places)[i]];
    // Its rows of pantin were measured beside the others; the chart has runs of its own.
    if (cells[scene] != name || cells[engine] == "pantin") continue;
    Result<Json> run = run_of(cells, fmt::format("{}:{}", printable(path), number));
    if (!run) return run.errors();
    runs.push_back(std::move(*run));
  }
  return runs;
}

void add_peers(Json& scene, Json peers) {
  Json all = scene["runs"];
  for (const Json& peer : peers) all.push_back(peer);
  mark_front(all,
             scene["reference"]["position_m"].is_number()
                 ? scene["reference"]["position_m"].get<double>()
                 : 0,
             "origin_m");
  const auto ours = static_cast<std::ptrdiff_t>(scene["runs"].size());
  scene["runs"] = Json(Json::array_t(all.begin(), all.begin() + ours));
  scene["peers"] = Json(Json::array_t(all.begin() + ours, all.end()));
}

}  // namespace pantin::program
