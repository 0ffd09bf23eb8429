// The same lamina by quasi-static modes and by dynamics, at falling speed of its fingers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "engine/runtime/simulation.hpp"
#include "tools/pantin/canvas.hpp"
#include "tools/pantin/modes.hpp"

namespace pantin::program {
namespace {

constexpr int kRows = 101;
constexpr std::array<double, 4> kSlower{1, 2, 4, 8};
constexpr double kApart = 0.02;    // of the way of the fastest finger: they have parted
constexpr double kInertia = 0.05;  // of the load: inertia counts
constexpr double kSettled = 0.1;   // of the duration, after which inertia is looked at

/// Mass centre (m) and angle (rad).
struct State {
  Vec2 at;
  double angle = 0;
};
struct Run {
  std::vector<State> states;    // at equal parts of the duration
  std::vector<double> inertia;  // largest m a over the load, in the part before
};

struct Quasistatic {
  Run run;
  StepEnd end;
  double time = 0;
  bool zeno = false, unstable = false;
  std::size_t choices = 0;
};

Quasistatic predict(const LaminaPlan& plan, double duration) {
  Quasistatic q;
  Course course{plan};
  for (int i = 0; i < kRows; ++i) {
    q.end = course.to(duration * i / (kRows - 1));
    if (q.end.ending != Ending::done) break;
    q.unstable |= course.stepper.motion.index < 0;
    q.run.states.push_back({course.centre(), course.stepper.placed.angle});
  }
  q.time = course.time, q.zeno = course.zeno, q.choices = course.choices;
  return q;
}

/// Nothing after a complaint, or an interruption.
std::optional<Run> simulate(const Scene& like, const LaminaPlan& plan, double duration,
                            double slower) {
  const auto scene =
      parse_scene(scene_of_dynamics(like, plan, duration, slower), "dynamics of " + plan.name);
  if (!scene) {
    for (const Error& e : scene.errors()) print_error(e.message);
    return std::nullopt;
  }
  Simulation sim(scene->world, {scene->step});
  const Entity body = sim.world.find(plan.name);
  const Vec3 load = plan.load();
  const double force = std::max(std::hypot(load.x, load.y), 1e-300);
  Run run;
  double time = 0;
  Vec3 velocity = sim.world.bodies[body].velocity;
  for (int i = 0; i < kRows; ++i) {
    double worst = 0;
    for (const double target = duration * slower * i / (kRows - 1); time < target - 1e-9;) {
      sim.settings.h = std::min(scene->step, target - time);
      if (sim.step().status == Status::diverged || interrupted()) return std::nullopt;
      time += sim.settings.h;
      const Vec3 now = sim.world.bodies[body].velocity;
      worst = std::max(worst, plan.mass * glm::length(now - velocity) / sim.settings.h / force);
      velocity = now;
    }
    const Pose& pose = sim.world.bodies[body].pose;
    const Quat q = sim.world.origin_pose(body).rotation;
    run.states.push_back({{pose.position.x, pose.position.y}, 2 * std::atan2(q.z, q.w)});
    run.inertia.push_back(worst);
  }
  return run;
}

/// The way of the fastest finger, m.
double way_of(const LaminaPlan& plan, double duration) {
  double way = 0;
  for (const FingerPlan& f : plan.fingers) {
    double sum = 0;
    for (std::size_t k = 0; k + 1 < f.path.size() && f.path[k].time < duration; ++k) {
      const Waypoint &a = f.path[k], &b = f.path[k + 1];
      sum += length(b.at - a.at) * std::min(1.0, (duration - a.time) / (b.time - a.time));
    }
    way = std::max(way, sum);
  }
  return way;
}

struct Parting {
  double worst = 0;  // m, of any point of the outline
  int row = -1;      // from which on they are apart
};

Parting compare(const LaminaPlan& plan, const Run& a, const Run& b, double way) {
  Parting p;
  const double size = extent(plan.outline);
  for (std::size_t i = 0; i < std::min(a.states.size(), b.states.size()); ++i) {
    const State &x = a.states[i], &y = b.states[i];
    const double away = length(x.at - y.at) + size / 2 * std::abs(x.angle - y.angle);
    p.worst = std::max(p.worst, away);
    if (p.row < 0 && away > kApart * way) p.row = static_cast<int>(i);
  }
  return p;
}

/// What of the quasi-static assumptions did not hold where they parted.
std::string broken(const Quasistatic& q, const Run& run, int row) {
  double inertia = 0;
  const int first = static_cast<int>(kSettled * kRows);
  for (int i = std::min(first, row); i <= row; ++i)
    inertia = std::max(inertia, run.inertia[static_cast<std::size_t>(i)]);
  if (inertia > kInertia)
    return fmt::format("inertia counts: m a reaches {:.0f} % of the load", 100 * inertia);
  if (q.choices > 1) return "several modes held: quasi-statics had to choose one";
  if (q.unstable) return "the mode has index -1: it is unstable when contacts yield";
  if (q.zeno) return "modes switch without end: the motion is an average of theirs";
  return "fingers of some size: the contact moves round them as the part turns";
}

void draw_panel(Canvas& canvas, const Frame& frame, const std::vector<const Run*>& runs,
                double (*value)(const State&)) {
  for (std::size_t r = runs.size(); r-- > 0;)
    for (std::size_t i = 0; i + 1 < runs[r]->states.size(); ++i) {
      const auto spot = [&](std::size_t k) {
        return frame.at(static_cast<double>(k) / (kRows - 1) * frame.across.high,
                        value(runs[r]->states[k]));
      };
      canvas.line(spot(i), spot(i + 1), r == 0 ? 4 : 1.5,
                  r == 0 ? Ink{190, 190, 190} : ink_of(r - 1));
    }
}

int draw(const LaminaPlan& plan, const ModesChoices& c, const std::vector<const Run*>& runs,
         const std::vector<std::string>& legend) {
  const auto canvas = make_canvas(c.out, 1140, 420 + 20 * static_cast<int>(legend.size()));
  if (!canvas) {
    complain("this build draws no PNG: configure with -DPANTIN_RENDER=ON, or name an .svg");
    return kFailed;
  }
  constexpr double (*kValues[])(const State&) = {[](const State& s) { return Real(s.at.x); },
                                                 [](const State& s) { return Real(s.at.y); },
                                                 [](const State& s) { return s.angle; }};
  constexpr const char* kNames[] = {"x, m", "y, m", "angle, rad"};
  for (int k = 0; k < 3; ++k) {
    double low = 1e300, high = -1e300;
    for (const Run* run : runs)
      for (const State& s : run->states)
        low = std::min(low, kValues[k](s)), high = std::max(high, kValues[k](s));
    const double rim = std::max(0.05 * (high - low), 1e-3);
    Frame frame{{80.0 + 370 * k, 60}, {270, 270}, {0, c.duration, "time at full speed, s"}, {}};
    frame.up = {low - rim, high + rim, kNames[k]};
    draw_panel(*canvas, frame, runs, kValues[k]);
    frame.draw(*canvas, k == 1 ? plan.name : "");
  }
  double y = 400;
  for (std::size_t i = 0; i < legend.size(); ++i, y += 20)
    canvas->text({40, y}, legend[i], i == 0 ? Ink{110, 110, 110} : ink_of(i - 1), Anchor::start);
  return write_or_complain(c.out, canvas->bytes());
}

std::string verdict_on(const Quasistatic& q, const ModesChoices& c, const Run& run,
                       const Parting& p) {
  if (q.run.states.empty()) return "nothing to compare";
  if (p.row < 0) return "they agree";
  return fmt::format("they part at {:.3g} s; {}", c.duration * p.row / (kRows - 1),
                     broken(q, run, p.row));
}

}  // namespace

int compare_with_dynamics(const Scene& scene, LaminaPlan plan, const ModesChoices& c) {
  if (!can_move(plan, c)) return kUsage;
  if (!(plan.mass > 0)) {
    complain(fmt::format("{}: lamina \"{}\": found mass 0, expected some for dynamics", c.scene,
                         plan.name));
    return kUsage;
  }
  bool two = false;
  for (FingerPlan& f : plan.fingers) two |= f.roll != f.slide, f.roll = f.slide;
  const Quasistatic q = predict(plan, c.duration);
  const double way = way_of(plan, c.duration);
  std::vector<Run> runs;
  Json j{{"lamina", plan.name}, {"way", way}, {"runs", Json::array()}};
  std::vector<std::string> legend{"quasi-static"};
  if (q.end.ending != Ending::done)
    legend[0] += fmt::format(", until {:.4g} s: {}", q.time, why(q.end));
  if (two) legend[0] += "; dynamics has one coefficient, both take the sliding one";
  j["quasistatic"] = legend[0];
  for (const double slower : kSlower) {
    auto run = simulate(scene, plan, c.duration, slower);
    if (!run) return interrupted() ? kInterrupted : kFailed;
    const Parting p = compare(plan, q.run, *run, way);
    const std::string words = verdict_on(q, c, *run, p);
    legend.push_back(
        fmt::format("dynamics, fingers at 1/{:g} speed: at most {:.2g} m apart, {:.2g} "
                    "% of the way; {}",
                    slower, p.worst, 100 * p.worst / std::max(way, 1e-300), words));
    j["runs"].push_back({{"slower", slower}, {"apart", p.worst}, {"words", words}});
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
