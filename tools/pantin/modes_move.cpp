// Moving laminas: the friction needed for a given motion, and the motion that follows from modes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/base/utf8.hpp"
#include "engine/modes/path.hpp"
#include "tools/pantin/modes.hpp"

namespace pantin::program {
namespace {

/// Sets the present normals and points of the touching fingers.
void prepare_now(const Course& course, Prepared& p) {
  double until;
  std::vector<Finger> fingers = fingers_at(course.plan, course.time, until);
  Moment now{course.part, fingers};
  now.place(course.stepper.placed);
  std::vector<Contact> contacts;
  for (const Touch& t : touches_of(now, 1e-9 * extent(course.plan.outline)))
    contacts.push_back(contact_of(now, t));
  p.count = 0, p.regions.clear();
  if (!contacts.empty()) prepare({contacts, load_of(now)}, p);
}

std::string mode_name(const Course& course) {
  const Motion& m = course.stepper.motion;
  std::string name(course.plan.fingers.size(), '.');
  for (std::size_t i = 0; i < m.touches.count; ++i) {
    char& c = name[m.touches.list[i].finger];
    c = m.signs.roll >> i & 1    ? 'R'
        : m.signs.plus >> i & 1  ? '+'
        : m.signs.minus >> i & 1 ? '-'
                                 : 'B';
  }
  return m.is_known ? name : "";
}

std::string head_of(const LaminaPlan& plan) {
  std::string text = "time_s,x_m,y_m,angle_rad,mode,index,switches";
  for (const FingerPlan& f : plan.fingers)
    text += fmt::format(",{0}_normal_N,{0}_tangent_N", f.name);
  return text + "\n";
}

std::string row_of(const Course& course) {
  const Stepper& s = course.stepper;
  const Vec2 centre = course.centre();
  std::string row =
      fmt::format("{:.9g},{:.12g},{:.12g},{:.12g},{},{},{}", course.time, centre.x, centre.y,
                  s.placed.angle, mode_name(course), s.motion.index, course.switches);
  for (std::size_t i = 0; i < course.plan.fingers.size(); ++i) {
    Real normal = 0, tangent = 0;
    for (std::size_t k = 0; k < s.motion.touches.count; ++k)
      if (s.motion.touches.list[k].finger == i)
        normal += s.motion.normal_force[k], tangent += s.motion.tangent_force[k];
    row += fmt::format(",{:.9g},{:.9g}", normal, tangent);
  }
  return row + "\n";
}

Json bound_json(Real bound) { return std::isfinite(bound) ? Json(bound) : Json(nullptr); }
std::string bound_words(Real bound) {
  return std::isfinite(bound) ? fmt::format("{:.4g}", bound) : "any";
}

}  // namespace

StepEnd Course::to(double target) {
  StepEnd end;
  while (time < target) {
    double until;
    std::vector<Finger> fingers = fingers_at(plan, time, until);
    const double stop = std::min(until, target);
    end = stepper.step(part, fingers, stop - time);
    switches += end.switches, zeno |= end.zeno;
    choices = std::max(choices, end.choices);
    time = end.ending == Ending::done ? stop : time + end.time;
    if (end.ending != Ending::done) break;
  }
  return end;
}

Vec2 Course::centre() const {
  const Placement& at = stepper.placed;
  return at.shift + turned(plan.centre, std::cos(at.angle), std::sin(at.angle));
}

std::string why(const StepEnd& end) {
  return end.ending == Ending::no_mode ? word_for(end.verdict) : word_for(end.ending);
}

int follow_path(LaminaPlan plan, const ModesChoices& c) {
  if (!can_move(plan, c)) return kUsage;
  for (FingerPlan& f : plan.fingers) f.roll = f.slide = 0;
  Course course{plan};
  PathBound bound;
  Prepared p;
  std::string text = "time_s,x_m,y_m,angle_rad,any_friction_up_to,one_friction_up_to\n", stopped;
  for (int i = 0; i < c.samples; ++i) {
    const StepEnd end = course.to(c.duration * i / (c.samples - 1));
    if (end.ending != Ending::done) {
      stopped = why(end);
      break;
    }
    prepare_now(course, p);
    bound.add(p);
    PathBound here;
    here.add(p);
    const Placement& at = course.stepper.placed;
    text += fmt::format("{:.9g},{:.12g},{:.12g},{:.12g},{:.9g},{:.9g}\n", course.time, at.shift.x,
                        at.shift.y, at.angle, here.each, here.common);
  }
  if (bound.poses == 0) {
    complain(fmt::format("{}: no motion without friction: {}", c.scene, stopped));
    return kFailed;
  }
  if (const int code = write_or_complain(c.path, text); code != kOk) return code;
  if (c.json) {
    print_json({{"lamina", plan.name},
                {"poses", bound.poses},
                {"stopped", stopped},
                {"stopped_at", course.time},
                {"any_friction_up_to", bound_json(bound.each)},
                {"one_friction_up_to", bound_json(bound.common)},
                {"without_plan", bound.without_plan},
                {"changes", bound.changes}});
    return kOk;
  }
  fmt::print("{}: planned without friction, {} poses over {:g} s\n", bold(printable(plan.name)),
             bound.poses, course.time);
  if (!stopped.empty()) fmt::print("  the plan ends at {:.6g} s: {}\n", course.time, stopped);
  fmt::print("  the motion stays as planned for any mixture of frictions up to {} (pose {})\n",
             bound_words(bound.each), bound.pose_of_each + 1);
  fmt::print("  and for one friction common to all up to {} (pose {}); not checked between poses\n",
             bound_words(bound.common), bound.pose_of_common + 1);
  return kOk;
}

/// Most mode switches reported for one sample.
constexpr int kMostSwitches = 16;
/// Relative to the interval between two samples.
constexpr double kSharp = 1e-9;

/// A mode, and its start time, s.
struct Began {
  double time = 0;
  std::string mode;
};

/// Appends the modes that begin before `target`, each with its time, found by bisection.
void add_switches(const Course& before, double target, std::vector<Began>& began) {
  std::optional<Course> course(before);
  for (int i = 0; i < kMostSwitches; ++i) {
    const auto differs = [&](const Course& later) {
      return later.switches > course->switches || mode_name(later) != mode_name(*course);
    };
    std::optional<Course> after(*course);
    after->to(target);
    if (!differs(*after)) return;
    double low = course->time, high = after->time;
    const double sharp = kSharp * (target - course->time);
    while (high - low > sharp) {
      const double middle = 0.5 * (low + high);
      Course there = *course;
      there.to(middle);
      if (differs(there))
        high = middle, after.emplace(there);
      else
        low = middle;
    }
    if (const std::string now = mode_name(*after);
        !now.empty() && (began.empty() || now != began.back().mode))
      began.push_back({began.empty() ? course->time : high, now});
    if (!(after->time > course->time)) return;
    course.emplace(*after);
  }
}

int move_on(const Scene& scene, const LaminaPlan& plan, const ModesChoices& c) {
  if (!can_move(plan, c)) return kUsage;
  Course course{plan};
  std::string text = head_of(plan), stopped;
  std::vector<Placement> places;
  std::vector<Began> began;
  for (int i = 0; i < c.samples; ++i) {
    const double target = c.duration * i / (c.samples - 1);
    const Course before = course;
    const StepEnd end = course.to(target);
    places.push_back(course.stepper.placed);
    add_switches(before, course.time, began);
    text += row_of(course);
    if (end.ending == Ending::done) continue;
    stopped = why(end);
    break;
  }
  if (c.move.ends_with(".json"))
    text = scene_along(scene, plan, {places, c.duration / (c.samples - 1)});
  if (const int code = write_or_complain(c.move, text); code != kOk) return code;
  const Placement& at = course.stepper.placed;
  if (c.json) {
    Json changes = Json::array();
    for (const auto& [time, mode] : began) changes.push_back({{"time", time}, {"mode", mode}});
    print_json({{"lamina", plan.name},
                {"time", course.time},
                {"shift", {at.shift.x, at.shift.y}},
                {"angle", at.angle},
                {"switches", course.switches},
                {"zeno", course.zeno},
                {"most_modes_at_once", course.choices},
                {"stopped", stopped},
                {"modes", changes}});
    return kOk;
  }
  fmt::print(
      "{}: {:g} s, {} switches of the mode; shifted by {:.6g} m, {:.6g} m, turned by {:.6g} "
      "rad\n",
      bold(printable(plan.name)), course.time, course.switches, at.shift.x, at.shift.y, at.angle);
  for (const auto& [time, mode] : began) fmt::print("  from {:.9g} s: {}\n", time, mode);
  if (course.choices > 1)
    fmt::print("  ambiguous at times: up to {} modes held at once\n", course.choices);
  if (course.zeno) fmt::print("  zeno: modes switched faster than can be resolved\n");
  if (!stopped.empty())
    fmt::print("  stopped at {:.6g} s: {}; dynamics has to continue from there\n", course.time,
               stopped);
  return kOk;
}

}  // namespace pantin::program
