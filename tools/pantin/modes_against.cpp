// Compares the quasi-static motion of a lamina with dynamics, at decreasing speeds of its fingers.
#include "tools/pantin/modes_against.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "tools/pantin/canvas.hpp"

namespace pantin::program {
namespace {

constexpr std::array<double, 4> kSlower{1, 2, 4, 8};

Parting compare(const LaminaPlan& plan, const Run& a, const Run& b, double way) {
  Parting p;
  const double size = extent(plan.outline);
  for (std::size_t i = 0; i < std::min(a.rows.size(), b.rows.size()); ++i) {
    const Row &x = a.rows[i], &y = b.rows[i];
    const double away = length(x.at - y.at) + size / 2 * std::abs(x.angle - y.angle);
    p.worst = std::max(p.worst, away);
    if (p.row < 0 && away > kApart * way) p.row = static_cast<int>(i);
  }
  return p;
}

/// The violated quasi-static assumptions where the runs diverge; if none is violated, the one
/// nearest to its bound.
std::string broken(const std::vector<Breach>& all) {
  std::string words;
  for (const Breach& b : all)
    if (b.part() >= 1) words += (words.empty() ? "" : "; ") + b.words;
  if (!words.empty()) return words;
  return "no assumption is violated; nearest: " + all.front().words;
}

Ink ink_of_run(std::size_t r) { return r == 0 ? Ink{190, 190, 190} : ink_of(r - 1); }

/// Polylines through the points of each run, the prediction below the others; points may be
/// missing.
template <class Point>
void draw_lines(Canvas& canvas, const std::vector<const Run*>& runs, const Point& point) {
  for (std::size_t r = runs.size(); r-- > 0;)
    for (std::size_t i = 1; i < runs[r]->rows.size(); ++i) {
      const std::optional<Spot> from = point(*runs[r], i - 1), to = point(*runs[r], i);
      if (from && to) canvas.line(*from, *to, r == 0 ? 4 : 1.5, ink_of_run(r));
    }
}

/// A chart of a value over time.
void draw_panel(Canvas& canvas, const Frame& frame, const std::vector<const Run*>& runs,
                double (*value)(const Row&)) {
  draw_lines(canvas, runs, [&](const Run& run, std::size_t i) -> std::optional<Spot> {
    return frame.at(static_cast<double>(i) / (kRows - 1) * frame.across.high, value(run.rows[i]));
  });
}

/// The friction used by two fingers: the coefficient of one that slides, less for one that sticks.
/// The mode alternates between the coefficients.
void draw_friction(Canvas& canvas, const LaminaPlan& plan, const std::vector<const Run*>& runs,
                   double left) {
  std::vector<std::size_t> two;
  for (std::size_t i = 0; i < plan.fingers.size() && two.size() < 2; ++i)
    if (plan.fingers[i].touches) two.push_back(i);
  if (two.size() < 2) return;
  double most = 0.01;
  for (const std::size_t i : two)
    most = std::max({most, plan.fingers[i].roll, plan.fingers[i].slide});
  const auto name = [&](std::size_t k) { return "friction used at " + plan.fingers[two[k]].name; };
  const Frame frame{{left, 60}, {270, 270}, {0, 1.15 * most, name(0)}, {0, 1.15 * most, name(1)}};
  draw_lines(canvas, runs, [&](const Run& run, std::size_t i) -> std::optional<Spot> {
    double used[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const AtFinger& f = run.rows[i].fingers[two[k]];
      if (!(f.normal > 0) || i == 0) return std::nullopt;
      used[k] = std::min(std::abs(f.tangent) / f.normal, 1.15 * most);
    }
    return frame.at(used[0], used[1]);
  });
  frame.draw(canvas, "");
}

int draw(const LaminaPlan& plan, const ModesChoices& c, const std::vector<const Run*>& runs,
         const std::vector<std::string>& legend) {
  const auto canvas = make_canvas(c.out, 1510, 420 + 20 * static_cast<int>(legend.size()));
  if (!canvas) {
    complain("this build draws no PNG: configure with -DPANTIN_RENDER=ON, or name an .svg");
    return kFailed;
  }
  constexpr double (*kValues[])(const Row&) = {[](const Row& s) { return Real(s.at.x); },
                                               [](const Row& s) { return Real(s.at.y); },
                                               [](const Row& s) { return s.angle; }};
  constexpr const char* kNames[] = {"x, m", "y, m", "angle, rad"};
  for (int k = 0; k < 3; ++k) {
    double low = 1e300, high = -1e300;
    for (const Run* run : runs)
      for (const Row& s : run->rows)
        low = std::min(low, kValues[k](s)), high = std::max(high, kValues[k](s));
    const double rim = std::max(0.05 * (high - low), 1e-3);
    Frame frame{{80.0 + 370 * k, 60}, {270, 270}, {0, c.duration, "time at full speed, s"}, {}};
    frame.up = {low - rim, high + rim, kNames[k]};
    draw_panel(*canvas, frame, runs, kValues[k]);
    frame.draw(*canvas, k == 1 ? plan.name : "");
  }
  draw_friction(*canvas, plan, runs, 80.0 + 370 * 3);
  canvas->text({1190, 440}, "A sliding finger uses its coefficient of", {}, Anchor::start);
  canvas->text({1190, 460}, "sliding, a sticking one up to that of sticking.", {}, Anchor::start);
  double y = 400;
  for (std::size_t i = 0; i < legend.size(); ++i, y += 20)
    canvas->text({40, y}, legend[i], i == 0 ? Ink{110, 110, 110} : ink_of_run(i), Anchor::start);
  return write_or_complain(c.out, canvas->bytes());
}

std::string verdict_on(const Prediction& q, const ModesChoices& c, const Parting& p,
                       const std::vector<Breach>& all) {
  if (q.run.rows.empty()) return "nothing to compare";
  if (p.row < 0) return "they agree";
  return fmt::format("they diverge at {:.3g} s: {}", c.duration * p.row / (kRows - 1), broken(all));
}

Json to_json(const std::vector<Breach>& all) {
  Json j = Json::array();
  for (const Breach& b : all)
    j.push_back({{"size", b.size}, {"bound", b.bound}, {"words", b.words}});
  return j;
}

}  // namespace

int compare_with_dynamics(const Scene& scene, const LaminaPlan& plan, const ModesChoices& c) {
  if (!can_move(plan, c)) return kUsage;
  if (!(plan.mass > 0)) {
    complain(fmt::format("{}: lamina \"{}\": found mass 0, expected some for dynamics", c.scene,
                         plan.name));
    return kUsage;
  }
  const Prediction q = predict(plan, c.duration);
  const double way = way_of(plan, c.duration);
  std::vector<Run> runs;
  Json j{{"lamina", plan.name}, {"way", way}, {"runs", Json::array()}};
  std::vector<std::string> legend{"quasi-static"};
  if (q.end.ending != Ending::done)
    legend[0] += fmt::format(", until {:.4g} s: {}", q.time, why(q.end));
  j["quasistatic"] = legend[0];
  for (const double slower : kSlower) {
    auto run = simulate(scene, plan, c.duration, slower);
    if (!run) return interrupted() ? kInterrupted : kFailed;
    const Parting p = compare(plan, q.run, *run, way);
    const std::vector<Breach> all =
        p.row < 0 || q.run.rows.empty() ? std::vector<Breach>{} : breaches(plan, q, *run, p);
    const std::string words = verdict_on(q, c, p, all);
    legend.push_back(
        fmt::format("dynamics, fingers at 1/{:g} speed: at most {:.2g} m apart, {:.2g} "
                    "% of the way; {}",
                    slower, p.worst, 100 * p.worst / std::max(way, 1e-300), words));
    j["runs"].push_back(
        {{"slower", slower}, {"apart", p.worst}, {"words", words}, {"breaches", to_json(all)}});
    runs.push_back(std::move(*run));
  }
  if (!c.out.empty()) {
    std::vector<const Run*> all{&q.run};
    for (const Run& run : runs) all.push_back(&run);
    if (const int code = draw(plan, c, all, legend); code != kOk) return code;
  }
  if (c.json) {
    print_json(j);
    return kOk;
  }
  fmt::print("{}\n", bold(printable(plan.name)));
  for (const std::string& line : legend) fmt::print("  {}\n", printable(line));
  return kOk;
}

}  // namespace pantin::program
