// Converts laminas of a scene to the input of the contact-mode library.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "engine/base/utf8.hpp"
#include "tools/pantin/modes.hpp"

namespace pantin::program {

namespace {

/// The contact points of a finger: for a flat one the corners that are on it.
std::vector<Vec2> points_of(const LaminaPlan& plan, const FingerPlan& f) {
  if (!f.flat || plan.outline.empty()) return {f.point};
  std::vector<Vec2> points;
  for (const Vec2 c : plan.outline)
    if (std::abs(dot(f.normal, c - f.point)) <= 1e-9 * extent(plan.outline)) points.push_back(c);
  return points;
}

}  // namespace

std::optional<Grasp> grasp_of(const LaminaPlan& plan, const std::string& file) {
  Grasp grasp;
  grasp.plan = &plan;
  for (std::size_t i = 0; i < plan.fingers.size(); ++i) {
    const FingerPlan& f = plan.fingers[i];
    if (!f.touches) continue;
    for (const Vec2 point : points_of(plan, f)) {
      grasp.fingers.push_back(i);
      grasp.contacts.push_back({point, f.normal, first_velocity(f)});
      grasp.roll.push_back(f.roll), grasp.slide.push_back(f.slide);
      grasp.spreads.push_back(f.spread);
    }
  }
  const Lamina lamina{grasp.contacts, plan.load()};
  const auto good = detail::modes::check(lamina);
  if (!good) {
    for (const Error& e : good.errors())
      print_error(fmt::format("{}: lamina \"{}\": {}", file, plan.name, e.message));
    return std::nullopt;
  }
  prepare(lamina, grasp.prepared);
  return grasp;
}

std::string in_words(const Grasp& grasp, const Signs& signs) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < grasp.contacts.size(); ++i) {
    const char* does = signs.roll >> i & 1                   ? "sticks"
                       : (signs.plus | signs.minus) >> i & 1 ? "slides"
                                                             : "separates";
    words.push_back(fmt::format("{} {}", grasp.name(i), does));
  }
  return fmt::format("{}", fmt::join(words, ", "));
}

std::vector<Finger> fingers_at(const LaminaPlan& plan, double time, double& until) {
  std::vector<Finger> all;
  until = 1e300;
  for (const FingerPlan& f : plan.fingers) {
    Finger finger;
    finger.normal = f.normal, finger.flat = f.flat, finger.roll = f.roll, finger.slide = f.slide;
    finger.at = f.path.back().at;
    for (std::size_t k = 0; k + 1 < f.path.size(); ++k) {
      const Waypoint &a = f.path[k], &b = f.path[k + 1];
      if (time < a.time || time >= b.time) continue;
      finger.velocity = 1 / (b.time - a.time) * (b.at - a.at);
      finger.at = a.at + (time - a.time) * finger.velocity;
      until = std::min(until, b.time);
    }
    all.push_back(finger);
  }
  return all;
}

bool can_move(const LaminaPlan& plan, const ModesChoices& c) {
  if (!plan.outline.empty()) return true;
  complain(fmt::format("{}: lamina \"{}\": found no \"outline\", expected one to move it by",
                       c.scene, plan.name));
  return false;
}

}  // namespace pantin::program
