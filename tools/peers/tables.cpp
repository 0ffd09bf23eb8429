// Tables, CSV and JSON of what was measured.
#include <algorithm>
#include <cmath>
#include <map>

#include "tools/peers/measure.hpp"

namespace pantin::peers {

namespace {

constexpr double kNever = INFINITY;

double of_round(const Point& p, int round) {
  if (p.ms.empty()) return NAN;
  return round < 0 ? median(p.ms) : p.ms[static_cast<std::size_t>(round)];
}

/// All points of one method at one size, coarse to fine.
using Ways = std::vector<std::span<const Point>>;

Ways ways_of(const Report& report, int links) {
  Ways ways;
  const Point* const all = report.points.data();
  for (std::size_t i = 0, j; i < report.points.size(); i = j) {
    const auto same = [&](const Point& p) {
      return p.links == all[i].links && p.peer == all[i].peer && p.method == all[i].method;
    };
    for (j = i; j < report.points.size() && same(all[j]);) ++j;
    if (all[i].links == links) ways.emplace_back(all + i, j - i);
  }
  return ways;
}

std::string name_of(const Report& report, const Point& p) {
  return report.peers[p.peer].name + " " + p.method->name;
}

std::string number(const char* format, double value) {
  if (!std::isfinite(value)) return "-";
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

double ns_per_step(const Point& p) {
  return p.ms.empty() || p.counts.steps <= 0
             ? NAN
             : 1e6 * median(p.ms) / (double(p.counts.steps) * p.links);
}

double ns_per_evaluation(const Point& p) {
  return p.ms.empty() || p.counts.evaluations <= 0
             ? NAN
             : 1e6 * median(p.ms) / (double(p.counts.evaluations) * p.links);
}

std::string setting_of(const Point& p) {
  return p.method->adaptive ? number("tol %.0e", p.setting)
                            : number("1/%.0f s", kFrames * p.setting);
}

void print_points(const Report& report, int links, std::FILE* out) {
  std::fprintf(out, "%-28s %-10s %9s %10s %7s %9s %9s %10s %9s %s\n", "method", "step", "error m",
               "CPU ms/s", "spread", "ns/l/step", "ns/l/eval", "energy %", "gap m", "");
  for (const Point& p : report.points) {
    if (p.links != links) continue;
    std::fprintf(out, "%-28s %-10s ", name_of(report, p).c_str(), setting_of(p).c_str());
    if (p.failed()) {
      std::fprintf(out, "failed at %.2f s\n", p.failed_at);
      continue;
    }
    std::fprintf(
        out, "%9s %10s %7s %9s %9s %10s %9s\n", number("%.1e", p.error).c_str(),
        number("%.3f", of_round(p, -1)).c_str(), number("%.0f %%", 100 * spread(p.ms)).c_str(),
        number("%.0f", ns_per_step(p)).c_str(), number("%.0f", ns_per_evaluation(p)).c_str(),
        number("%+.1e", 100 * p.energy).c_str(), number("%.0e", p.gap).c_str());
  }
}

/// The cheapest of some ways to a level.
struct Best {
  double ms = kNever;
  std::string name = "-";
};

/// What a peer of ours needs over what the best of the others needs.
struct Gear {
  double level = 0;
  bool exact = true;  // by the exact solver; else by any
  Best ours, others;
  double median = NAN, low = NAN, high = NAN;  // over the rounds
};

/// Which methods of ours are compared.
enum class Methods { exact, all };

/// A peer of ours beside the others, at one size.
struct Comparison {
  const Report& report;
  Ways ways;         // of that size
  std::size_t ours;  // the peer

  template <class Take>
  Best best_of(double level, int round, const Take& take) const;
  Gear ratio_at(double level, Methods methods) const;
};

template <class Take>
Best Comparison::best_of(double level, int round, const Take& take) const {
  Best best;
  for (const auto& way : ways) {
    if (!take(way.front())) continue;
    const double ms = cost_at(way, level, round);
    if (ms < best.ms) best = {ms, name_of(report, way.front())};
  }
  return best;
}

Gear Comparison::ratio_at(double level, Methods methods) const {
  const bool exact = methods == Methods::exact;
  const auto take = [&](const Point& p) { return p.peer == ours && (!exact || p.method->exact); };
  const auto leave = [&](const Point& p) { return !report.peers[p.peer].ours(); };
  Gear r{level, exact, best_of(level, -1, take), best_of(level, -1, leave)};
  std::vector<double> rounds;
  for (int round = 0; round < report.rounds; ++round) {
    const double mine = best_of(level, round, take).ms;
    const double theirs = best_of(level, round, leave).ms;
    if (std::isfinite(mine) && std::isfinite(theirs)) rounds.push_back(mine / theirs);
  }
  if (!rounds.empty()) {
    r.median = median(rounds);
    const auto [low, high] = std::minmax_element(rounds.begin(), rounds.end());
    r.low = *low, r.high = *high;
  }
  return r;
}

/// At every level by the exact solver; and by another of ours where that is cheaper.
std::vector<Gear> ratios_of(const Report& report, int links, std::size_t ours) {
  std::vector<Gear> gears;
  const Comparison comparison{report, ways_of(report, links), ours};
  for (const double level : kLevels) {
    gears.push_back(comparison.ratio_at(level, Methods::exact));
    const Gear any = comparison.ratio_at(level, Methods::all);
    if (any.ours.name != gears.back().ours.name) gears.push_back(any);
  }
  return gears;
}

void print_levels(const Report& report, int links, std::FILE* out) {
  std::fprintf(out, "\nCPU ms for a second of %d links at equal error\n%-28s", links, "method");
  for (const double level : kLevels) std::fprintf(out, " %12s", number("%.0e m", level).c_str());
  std::fputc('\n', out);
  for (const auto& way : ways_of(report, links)) {
    std::fprintf(out, "%-28s", name_of(report, way.front()).c_str());
    for (const double level : kLevels)
      std::fprintf(out, " %12s", number("%.3f", cost_at(way, level, -1)).c_str());
    std::fputc('\n', out);
  }
  for (std::size_t peer = 0; peer < report.peers.size(); ++peer) {
    if (!report.peers[peer].ours()) continue;
    for (const Gear& r : ratios_of(report, links, peer)) {
      if (!std::isfinite(r.median)) continue;
      std::fprintf(out, "  %.0e m: %-28s %10.3f ms over %-22s %10.3f ms = %.2f (%.2f to %.2f)\n",
                   r.level, r.ours.name.c_str(), r.ours.ms, r.others.name.c_str(), r.others.ms,
                   r.median, r.low, r.high);
    }
  }
}

std::vector<int> sizes_of(const Report& report) {
  std::vector<int> sizes;
  for (const Point& p : report.points)
    if (sizes.empty() || sizes.back() != p.links) sizes.push_back(p.links);
  return sizes;
}

const Reference* reference_of(const Report& report, int links) {
  for (const Reference& r : report.references)
    if (r.links == links) return &r;
  return nullptr;
}

/// One step of each method at 1/960 s, by size.
void print_cost(const Report& report, std::FILE* out) {
  const std::vector<int> sizes = sizes_of(report);
  std::fprintf(out, "\nns for a link and a step of 1/960 s (for a link and an evaluation)\n%-28s",
               "method");
  for (const int links : sizes) std::fprintf(out, " %9d links", links);
  std::fputc('\n', out);
  std::vector<std::string> names;
  std::map<std::string, std::map<int, std::string>> cells;
  for (const Point& p : report.points) {
    if (p.method->adaptive || kFrames * p.setting != 960) continue;
    const std::string name = name_of(report, p);
    if (!cells.contains(name)) names.push_back(name);
    std::string& cell = cells[name][p.links];
    cell = p.failed() ? "failed" : number("%.0f", ns_per_step(p));
    if (!p.failed()) cell += " (" + number("%.0f", ns_per_evaluation(p)) + ")";
  }
  for (const std::string& name : names) {
    std::fprintf(out, "%-28s", name.c_str());
    for (const int links : sizes) std::fprintf(out, " %15s", cells[name][links].c_str());
    std::fputc('\n', out);
  }
}

std::string json_number(double value) {
  return std::isfinite(value) ? number("%.6g", value) : "null";
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

double spread(const std::vector<double>& values) {
  if (values.empty()) return NAN;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return (*high - *low) / median(values);
}

double cost_at(std::span<const Point> way, double level, int round) {
  double best = kNever;
  const Point* before = nullptr;
  for (const Point& p : way) {
    if (p.failed() || p.ms.empty() || !std::isfinite(p.error)) continue;
    const double ms = of_round(p, round);
    if (p.error <= level) best = std::min(best, ms);
    if (before && before->error > level && p.error <= level) {
      const double high = std::log(before->error), low = std::log(std::max(p.error, 1e-18));
      const double part = (high - std::log(level)) / (high - low);
      const double from = std::log(of_round(*before, round));
      best = std::min(best, std::exp(from + part * (std::log(ms) - from)));
    }
    before = &p;
  }
  return best;
}

void print_tables(const Report& report, std::FILE* out) {
  std::fprintf(out, "Engines, all in double:\n");
  for (const Peer& peer : report.peers)
    std::fprintf(out, "  %-14s %-14s %s\n", peer.name.c_str(), peer.engine->version,
                 peer.engine->built);
  for (const int links : sizes_of(report)) {
    std::fprintf(out, "\n== %d links, a second from level at rest ==\n", links);
    if (const Reference* r = reference_of(report, links)) {
      std::fprintf(out, "reference: %s", r->from.c_str());
      for (const auto& [name, apart] : r->apart)
        std::fprintf(out, "; %s is %.1e m from it", name.c_str(), apart);
      std::fputc('\n', out);
    }
    print_points(report, links, out);
    if (reference_of(report, links)) print_levels(report, links, out);
  }
  print_cost(report, out);
  std::vector<double> spreads;
  for (const Point& p : report.points)
    if (!p.ms.empty()) spreads.push_back(spread(p.ms));
  std::fprintf(out,
               "\n%d rounds, each through everything in another order and process; medians. Spread "
               "(widest less"
               " narrowest\nover median): median %.0f %%, worst %.0f %%. CPU %.0f s of %.0f s that"
               " passed; load %.2f before, %.2f after.\n",
               report.rounds, 100 * median(spreads),
               spreads.empty() ? NAN : 100 * *std::max_element(spreads.begin(), spreads.end()),
               report.cpu_seconds, report.wall_seconds, report.load_before, report.load_after);
}

void print_csv(const Report& report, std::FILE* out) {
  std::fprintf(out,
               "engine,method,links,step_s,tolerance,error_m,cpu_ms_per_s,spread,"
               "ns_per_link_step,ns_per_link_evaluation,energy_percent,gap_m,failed_at_s\n");
  for (const Point& p : report.points) {
    std::fprintf(out, "%s,%s,%d,%.6g,%.6g,", report.peers[p.peer].name.c_str(), p.method->name,
                 p.links, p.step(), p.method->adaptive ? p.setting : 0.0);
    if (p.failed())
      std::fprintf(out, ",,,,,,,%.4f\n", p.failed_at);
    else
      std::fprintf(out, "%.4e,%.5g,%.3f,%.1f,%.1f,%.3e,%.1e,\n", p.error, of_round(p, -1),
                   spread(p.ms), ns_per_step(p), ns_per_evaluation(p), 100 * p.energy, p.gap);
  }
}

void print_json(const Report& report, std::FILE* out) {
  std::fprintf(out,
               "{\n  \"rounds\": %d, \"cpu_s\": %.1f, \"wall_s\": %.1f, \"load\": [%.2f, %.2f],\n",
               report.rounds, report.cpu_seconds, report.wall_seconds, report.load_before,
               report.load_after);
  const char* comma = "";
  std::fputs("  \"engines\": [", out);
  for (const Peer& peer : report.peers) {
    std::fprintf(out, "%s\n    {\"name\": \"%s\", \"version\": \"%s\", \"built\": \"%s\"}", comma,
                 peer.name.c_str(), peer.engine->version, peer.engine->built);
    comma = ",";
  }
  std::fputs("\n  ],\n  \"references\": [", out);
  comma = "";
  for (const Reference& r : report.references) {
    std::fprintf(out, "%s\n    {\"links\": %d, \"from\": \"%s\", \"apart_m\": {", comma, r.links,
                 r.from.c_str());
    const char* inner = "";
    for (const auto& [name, apart] : r.apart)
      std::fprintf(out, "%s\"%s\": %s", inner, name.c_str(), json_number(apart).c_str()),
          inner = ", ";
    std::fputs("}}", out);
    comma = ",";
  }
  std::fputs("\n  ],\n  \"points\": [", out);
  comma = "";
  for (const Point& p : report.points) {
    std::fprintf(out,
                 "%s\n    {\"engine\": \"%s\", \"method\": \"%s\", \"links\": %d, \"step_s\": %s, "
                 "\"tolerance\": %s, \"failed_at_s\": %s",
                 comma, report.peers[p.peer].name.c_str(), p.method->name, p.links,
                 p.method->adaptive ? "null" : json_number(p.step()).c_str(),
                 p.method->adaptive ? json_number(p.setting).c_str() : "null",
                 p.failed() ? json_number(p.failed_at).c_str() : "null");
    if (!p.failed())
      std::fprintf(out,
                   ", \"error_m\": %s, \"cpu_ms_per_s\": %s, \"spread\": %s, "
                   "\"ns_per_link_step\": %s, \"ns_per_link_evaluation\": %s, "
                   "\"energy_percent\": %s, \"gap_m\": %s",
                   json_number(p.error).c_str(), json_number(of_round(p, -1)).c_str(),
                   json_number(spread(p.ms)).c_str(), json_number(ns_per_step(p)).c_str(),
                   json_number(ns_per_evaluation(p)).c_str(), json_number(100 * p.energy).c_str(),
                   json_number(p.gap).c_str());
    std::fputs("}", out);
    comma = ",";
  }
  std::fputs("\n  ],\n  \"equal_error\": [", out);
  comma = "";
  for (const Reference& reference : report.references)
    for (std::size_t peer = 0; peer < report.peers.size(); ++peer) {
      if (!report.peers[peer].ours()) continue;
      for (const Gear& r : ratios_of(report, reference.links, peer)) {
        std::fprintf(out,
                     "%s\n    {\"links\": %d, \"error_m\": %g, \"exact\": %s, "
                     "\"ours\": \"%s\", \"ours_ms\": %s, \"peer\": \"%s\", \"peer_ms\": %s, "
                     "\"ratio\": %s, \"lowest\": %s, "
                     "\"highest\": %s}",
                     comma, reference.links, r.level, r.exact ? "true" : "false",
                     r.ours.name.c_str(), json_number(r.ours.ms).c_str(), r.others.name.c_str(),
                     json_number(r.others.ms).c_str(), json_number(r.median).c_str(),
                     json_number(r.low).c_str(), json_number(r.high).c_str());
        comma = ",";
      }
    }
  std::fputs("\n  ]\n}\n", out);
}

}  // namespace pantin::peers
