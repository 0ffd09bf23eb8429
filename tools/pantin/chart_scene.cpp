// Measures a scene for `pantin chart`: a reference, then all methods over a ladder of steps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/base/hash.hpp"
#include "engine/world/lamina.hpp"
#include "tools/pantin/chart.hpp"
#include "tools/pantin/findings.hpp"
#include "tools/pantin/subject.hpp"

namespace pantin::program {
namespace {

constexpr double kReferencePart = 0.35, kRunsPart = 0.7;  // of the time for a scene

/// One point of the chart before it is measured.
struct Point {
  const Loaded* loaded = nullptr;
  double step = 0, tolerance = 0;
  std::string key;
};

class SceneChart {
 public:
  SceneChart(const std::string& path, const ChartChoices& c, Journal& journal)
      : path_(path), c_(c), journal_(journal), begin_(wall_seconds()), progress_(path) {}

  Result<Json> make();

 private:
  Result<Done> find_reference();
  void list_points();
  Result<Done> measure_runs();
  Result<Done> time_runs();
  Json run_of(const Point& point) const;
  Json compared(const Point& point, const Outcome& outcome) const;
  Json reference_json() const;
  Json as_json();
  Trial trial_of(const Point& point) const;
  double left(double part) const { return begin_ + part * c_.time - wall_seconds(); }
  std::string key(const std::string& what) const { return subject_.key + "|" + what; }

  std::string path_;
  const ChartChoices& c_;
  Journal& journal_;
  double begin_;  // s
  Progress progress_;
  Subject subject_;
  Reference reference_;
  std::vector<Point> points_;
};

Result<Done> SceneChart::find_reference() {
  if (!c_.against.empty()) {
    Result<Reference> read =
        read_reference(c_.against, subject_.own().world, kMostSamples, subject_.sampling);
    if (!read) return read.errors();
    reference_ = std::move(*read);
  } else {
    Result<std::optional<Reference>> exact = exact_motion(subject_);
    if (!exact) return exact.errors();
    if (*exact) reference_ = std::move(**exact);
  }
  const bool is_given = reference_.track.samples() > 0;
  if (is_given) {
    Hash hash;
    for (const Pose& p : reference_.track.poses) hash.add(p);
    for (const double energy : reference_.track.energies) hash.add(energy);
    subject_.key += "|" + hex(hash.value());
  }
  subject_.key += fmt::format("|{}|{}|{}|{}", subject_.sampling.interval, subject_.sampling.count,
                              subject_.sampling.between, c_.against);
  if (is_given) return Done{};
  const Search search{
      subject_.sampling,
      std::ldexp(subject_.sampling.interval / subject_.coarsest_steps(), -(c_.rungs - 2)),
      kReferencePart * c_.time};
  Result<Reference> found = reference_of(subject_, journal_, search);
  if (!found) return found.errors();
  reference_ = std::move(*found);
  return Done{};
}

void SceneChart::list_points() {
  const Scene& scene = subject_.own();
  const auto* laminas = laminas_of(scene.world);
  const bool is_mixed = scene.world.settings.size() > 0 || (laminas && laminas->size() > 0);
  const double whole = subject_.coarsest_steps();
  for (int rung = 0; rung < c_.rungs; ++rung)
    for (const Loaded& l : subject_.loaded) {
      const std::string& name = l.method.name;
      const bool is_asked = c_.methods.empty() ? name != "scene" || is_mixed
                                               : std::find(c_.methods.begin(), c_.methods.end(),
                                                           name) != c_.methods.end();
      if (!l.scene || !is_asked) continue;
      Point point{&l, subject_.sampling.interval / std::ldexp(whole, rung), 0, {}};
      if (l.method.is_adaptive)
        point.step = subject_.sampling.interval / whole,
        point.tolerance = std::pow(10.0, -3 - rung);
      point.key = key(fmt::format("{}|{}|{}", name, point.step, point.tolerance));
      points_.push_back(point);
    }
}

Trial SceneChart::trial_of(const Point& point) const {
  return {&*point.loaded->scene, point.step, point.tolerance, subject_.sampling, true};
}

/// What was measured of a run, as an object.
Json SceneChart::compared(const Point& point, const Outcome& o) const {
  Json run{{"method", point.loaded->method.name}, {"step_s", point.step}};
  run["tolerance"] = point.tolerance > 0 ? Json(point.tolerance) : Json(nullptr);
  run["status"] = o.status, run["reason"] = o.reason, run["ended_at_s"] = o.ended_at;
  const bool known = o.is_ok() && reference_.holds();
  const Apart error =
      known ? apart(o.track, reference_.track, std::min(reference_.compared, o.track.samples()))
            : Apart{};
  const double none = std::numeric_limits<double>::quiet_NaN();
  run["position_m"] = json_number(known ? error.position : none);
  run["origin_m"] = json_number(known ? error.origin : none);
  run["orientation_rad"] = json_number(known ? error.orientation : none);
  run["energy_j"] = json_number(known ? error.energy : none);
  const std::size_t follows =
      reference_.holds() ? std::min(reference_.agreed, agreement(o.track, reference_.track,
                                                                 kFollows * reference_.size))
                         : 0;
  run["follows_s"] =
      follows > 0 ? static_cast<double>(follows - 1) * subject_.sampling.spacing() : 0.0;
  run["joints_m"] = json_number(o.gap), run["depth_m"] = json_number(o.depth);
  run["steps"] = o.counts.steps, run["factorisations"] = o.counts.factorisations;
  run["iterations"] = o.counts.iterations, run["substeps"] = o.counts.substeps;
  run["sweeps"] = o.counts.sweeps;
  run["unsolved_steps"] = o.unsolved, run["rescued_steps"] = o.rescued;
  std::set<std::string> kinds;
  for (const Finding& f : o.findings) kinds.emplace(info_of(f.kind).name);
  run["findings"] = kinds;
  run["measured_s"] = o.seconds;
  return run;
}

Result<Done> SceneChart::measure_runs() {
  const bool all_known = std::all_of(points_.begin(), points_.end(), [&](const Point& p) {
    return journal_.find(p.key) != nullptr;
  });
  if (!all_known) rerun(subject_, reference_);
  // The cheapest next run first, so that little time still makes a chart of all methods.
  struct Ladder {
    std::vector<const Point*> left;  // the finest first
    double next = 0;                 // s, as far as it can be known
  };
  std::map<const Loaded*, Ladder> ladders;
  for (auto p = points_.rbegin(); p != points_.rend(); ++p) ladders[p->loaded].left.push_back(&*p);
  for (std::size_t done = 0; !ladders.empty() && !interrupted(); ++done) {
    progress_.show(0.5 * static_cast<double>(done) / static_cast<double>(points_.size()));
    const auto cheapest = std::ranges::min_element(
        ladders, {}, [](const auto& of) { return std::pair(of.second.next, of.first); });
    Ladder& ladder = cheapest->second;
    const Point& point = *ladder.left.back();
    const Json* known = journal_.find(point.key);
    if (!known && left(kRunsPart) < ladder.next) break;
    double seconds = known ? (*known)["measured_s"].get<double>() : 0;
    if (!known) {
      Trial trial = trial_of(point);
      trial.stop = [&](double) { return left(kRunsPart) < 0; };
      const Outcome outcome = run_motion(trial);
      if (outcome.status == "stopped") break;
      seconds = outcome.seconds;
      if (auto kept = journal_.add(point.key, compared(point, outcome)); !kept) return kept;
    }
    ladder.next = 2 * seconds;  // half the step
    ladder.left.pop_back();
    if (ladder.left.empty()) ladders.erase(cheapest);
  }
  return Done{};
}

/// Every round times all runs, in opposite order each time: load on the machine meets all alike.
Result<Done> SceneChart::time_runs() {
  std::vector<const Point*> order;
  for (const Point& p : points_)
    if (const Json* run = journal_.find(p.key); run && (*run)["status"] == "ok")
      order.push_back(&p);
  for (int round = 0; round < c_.repeat; ++round, std::reverse(order.begin(), order.end())) {
    std::size_t done = 0;
    for (const Point* point : order) {
      progress_.show(
          0.5 + 0.5 * (round + static_cast<double>(done++) / static_cast<double>(order.size())) /
                    c_.repeat);
      const std::string name = fmt::format("{}|round {}", point->key, round);
      if (interrupted()) return Done{};
      // A run that does not fit into the time that is left has fewer rounds.
      const double likely = (*journal_.find(point->key))["measured_s"].get<double>();
      if (journal_.find(name) || left(1) < likely) continue;
      const double seconds = time_run(trial_of(*point));
      if (interrupted() || !std::isfinite(seconds)) continue;
      if (auto kept = journal_.add(name, seconds); !kept) return kept;
    }
  }
  return Done{};
}

Json SceneChart::run_of(const Point& point) const {
  const Scene& scene = subject_.own();
  const Json* known = journal_.find(point.key);
  Json run = known
                 ? *known
                 : Json{{"method", point.loaded->method.name},
                        {"step_s", point.step},
                        {"tolerance", point.tolerance > 0 ? Json(point.tolerance) : Json(nullptr)},
                        {"status", "not_run"},
                        {"reason", "the time was over"}};
  std::vector<double> costs;
  std::size_t bodies = 0;
  for (const Body& b : scene.world.bodies.values()) bodies += b.motion == Motion::dynamic;
  const double per =
      1e9 / (static_cast<double>(std::max<std::size_t>(1, bodies)) * subject_.sampling.duration());
  for (int round = 0; round < c_.repeat; ++round)
    if (const Json* s = journal_.find(fmt::format("{}|round {}", point.key, round)))
      costs.push_back(per * s->get<double>());
  run["cost_ns"] = costs.empty() ? Json(nullptr) : Json(percentile(costs, 0.5));
  run["cost_low_ns"] = costs.empty() ? Json(nullptr) : Json(costs.front());
  run["cost_high_ns"] = costs.empty() ? Json(nullptr) : Json(costs.back());
  run["rounds"] = costs.size();
  // With measures, once: where a failed run is drawn.
  if (known) run["cost_measured_ns"] = per * run["measured_s"].get<double>();
  run.erase("measured_s");
  return run;
}

Json SceneChart::reference_json() const {
  const Reference& r = reference_;
  const auto horizon = [&](std::size_t agreed) {
    return agreed > 0 ? static_cast<double>(agreed - 1) * subject_.sampling.spacing() : 0.0;
  };
  Json j{{"method", r.method},
         {"step_s", r.step},
         {"position_m", json_number(r.own.position)},
         {"orientation_rad", json_number(r.own.orientation)},
         {"energy_j", json_number(r.own.energy)},
         {"horizon_s", horizon(r.agreed)},
         {"compared_s", horizon(r.compared)},
         {"whole", r.is_whole(subject_.sampling)}};
  const std::optional<double> unseen = event_unseen(subject_, r);
  j["unseen_event_s"] = unseen ? Json(*unseen) : Json(nullptr);
  j["tried"] = Json::array();
  for (const Reference::Tried& t : r.tried)
    j["tried"].push_back({{"method", t.method},
                          {"step_s", t.step},
                          {"position_m", t.own.position},
                          {"horizon_s", horizon(t.agreed)}});
  return j;
}

Json SceneChart::as_json() {
  const Scene& scene = subject_.own();
  std::size_t bodies = 0;
  for (const Body& b : scene.world.bodies.values()) bodies += b.motion == Motion::dynamic;
  const double per_body = 1e9 / static_cast<double>(std::max<std::size_t>(1, bodies));
  Json j{{"scene", path_},
         {"title", scene.title},
         {"bodies", bodies},
         {"joints", scene.world.links.size()},
         {"duration_s", subject_.sampling.duration()},
         {"samples", subject_.sampling.samples()},
         {"substeps", scene.substeps},
         {"own_solver", describe_solvers(scene.world)},
         {"own_step_s", scene.step},
         {"size_m", reference_.size},
         {"real_time_ns", per_body},
         {"tenth_of_frame_ns", 0.1 * per_body}};
  j["reference"] = reference_json();
  j["refused"] = Json::array();
  for (const Loaded& l : subject_.loaded)
    if (!l.scene && (c_.methods.empty() || std::ranges::count(c_.methods, l.method.name) > 0))
      j["refused"].push_back({{"method", l.method.name}, {"reason", l.refusal}});
  Json runs = Json::array();
  for (const Point& point : points_) runs.push_back(run_of(point));
  mark_front(runs, std::isfinite(reference_.own.position) ? reference_.own.position : 0,
             "position_m");
  // Another method that comes near the reference confirms it.
  double nearest = std::numeric_limits<double>::infinity();
  std::string by;
  for (const Json& run : runs)
    if (run["method"] != reference_.method && run.value("position_m", Json(nullptr)).is_number() &&
        run["position_m"].get<double>() < nearest)
      nearest = run["position_m"].get<double>(), by = run["method"].get<std::string>();
  j["reference"]["confirmed_by"] = by;
  j["reference"]["confirmed_m"] = json_number(nearest);
  j["runs"] = std::move(runs);
  return j;
}

Result<Json> SceneChart::make() {
  Result<Subject> subject = read_subject(path_, {c_.duration, c_.coarsest});
  if (!subject) return subject.errors();
  subject_ = std::move(*subject);
  progress_.show(0);
  if (auto done = find_reference(); !done) return done.errors();
  list_points();
  if (auto done = measure_runs(); !done) return done.errors();
  if (auto done = time_runs(); !done) return done.errors();
  return as_json();
}

}  // namespace

Result<Json> chart_scene(const std::string& path, const ChartChoices& choices, Journal& journal) {
  return SceneChart(path, choices, journal).make();
}

void mark_front(Json& runs, double floor, const std::string& error_key) {
  const auto point = [&](const Json& run) {
    const bool known = run["status"] == "ok" && run["cost_ns"].is_number() &&
                       run.value(error_key, Json(nullptr)).is_number();
    const double none = std::numeric_limits<double>::quiet_NaN();
    return std::pair(known ? run["cost_ns"].get<double>() : none,
                     known ? std::max(floor, run[error_key].get<double>()) : none);
  };
  for (Json& run : runs) {
    const auto [cost, error] = point(run);
    bool is_best = std::isfinite(cost);
    for (const Json& other : runs) {
      const auto [c, e] = point(other);
      is_best = is_best && !((c < cost && e <= error) || (c <= cost && e < error));
    }
    run["front"] = is_best;
  }
}

}  // namespace pantin::program
