// The modes of a lamina at given friction, in words or as JSON.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "tools/pantin/modes.hpp"

namespace pantin::program {
namespace {

/// A mode, as input of both output formats.
struct Told {
  std::string name;
  Signs signs;
  Vec3 twist{0};
  std::array<Real, kMostContacts> normal{}, tangent{}, slip{};
  const Region* region = nullptr;
  int index = 0;
  std::array<Real, kMostContacts> parting{};  // m/s, along the normals
  bool boundary = false, break_tie = false, motion_unique = true, forces_unique = true;

  bool bears(std::size_t i) const { return (signs.roll | signs.plus | signs.minus) >> i & 1; }
};
/// m/s, relative to the fastest motion: a finger that separates more slowly keeps its contact.
constexpr Real kStays = 1e-9;

/// The velocity of the lamina at a finger, relative to it, m/s.
Vec2 past(const Contact& c, Vec3 twist) {
  return Vec2{twist.x - twist.z * c.point.y, twist.y + twist.z * c.point.x} - c.velocity;
}

Told told_of(const Grasp& g, const FeasibleMode& mode) {
  Told told;
  const Region& r = g.prepared.regions[static_cast<std::size_t>(mode.region)];
  const SignedMode by_contact = signed_mode_of(g.prepared, mode, g.friction());
  told.name = name_of(g.prepared, r), told.signs = by_contact.signs, told.twist = r.twist;
  told.normal = by_contact.normal_force, told.tangent = by_contact.tangent_force;
  told.region = &r, told.index = mode.index;
  told.boundary = mode.boundary, told.break_tie = mode.break_tie;
  return told;
}

Told told_of(const Grasp& g, const SignedMode& mode) {
  Told told;
  told.name = name_of(mode.signs, g.contacts.size()), told.signs = mode.signs;
  told.twist = mode.twist, told.normal = mode.normal_force, told.tangent = mode.tangent_force;
  told.motion_unique = mode.motion_unique, told.forces_unique = mode.forces_unique;
  return told;
}

std::vector<Told> all_of(const Grasp& g, const ModeSet& set) {
  std::vector<Told> all;
  for (const FeasibleMode& m : set.modes) all.push_back(told_of(g, m));
  for (const SignedMode& m : set.indeterminate) all.push_back(told_of(g, m));
  for (Told& t : all)
    for (std::size_t i = 0; i < g.contacts.size(); ++i) {
      const Contact& c = g.contacts[i];
      const Vec2 v = past(c, t.twist);
      t.slip[i] = dot(tangent_of(c.normal), v), t.parting[i] = dot(c.normal, v);
    }
  return all;
}

const char* sentence_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::unique:
      return "one mode holds";
    case Verdict::ambiguous:
      return "several modes hold; friction alone does not determine which one occurs";
    case Verdict::squeezed:
      return "no mode: every motion would penetrate a finger, the lamina is squeezed";
    case Verdict::no_balance:
      return "no mode: no forces within friction balance the load, the lamina slips or falls";
    case Verdict::conflict:
      return "no mode: motions and forces exist, but none are compatible; it jams or escapes";
    case Verdict::unresolved:
      break;
  }
  return "undecided: too many combinations";
}

std::string interval_words(const Interval& i) {
  return std::isfinite(i.high) ? fmt::format("{:.4g} to {:.4g}", i.low, i.high)
                               : fmt::format("{:.4g} upwards", i.low);
}

/// Whether a finger without force does not separate either, so that it could carry force.
bool stays(const Grasp& g, const Told& t, std::size_t i) {
  Real fastest = 0;
  for (const Contact& c : g.contacts) {
    const Vec2 v = past(c, t.twist);
    fastest = std::max({fastest, std::hypot(v.x, v.y), std::hypot(c.velocity.x, c.velocity.y)});
  }
  return !t.bears(i) && t.parting[i] <= kStays * fastest;
}

void print_contact(const Grasp& g, const Told& t, std::size_t i) {
  const bool rolls = t.signs.roll >> i & 1, slides = (t.signs.plus | t.signs.minus) >> i & 1;
  const std::string does = rolls            ? "sticks"
                           : slides         ? fmt::format("slides at {:.4g} m/s", t.slip[i])
                           : stays(g, t, i) ? "no force, stays in contact"
                                            : fmt::format("separates at {:.4g} m/s", t.parting[i]);
  const std::string forces =
      rolls || slides ? fmt::format("{:.4g} N into it, {:.4g} N along", t.normal[i], t.tangent[i])
                      : "";
  fmt::print("    {:<12} {:<24} {}\n", printable(g.name(i)), does, forces);
}

void print_mode(const Grasp& g, const Told& t) {
  fmt::print("  {}  moves at {:.4g} m/s, {:.4g} m/s, {:.4g} rad/s (its point at the origin)\n",
             t.name, t.twist.x, t.twist.y, t.twist.z);
  for (std::size_t i = 0; i < g.contacts.size(); ++i) print_contact(g, t, i);
  if (!t.motion_unique) fmt::print("    the motion is not unique\n");
  if (!t.forces_unique) fmt::print("    the forces are not unique\n");
  if (t.break_tie)
    fmt::print(
        "    a tie: contacts without force stay closed; their share of the load is undetermined\n");
  if (t.boundary) fmt::print("    on its boundary: the neighbouring mode holds too\n");
  if (!t.region) return;
  std::string all;
  for (const Interval& i : equal_friction(*t.region))
    all += (all.empty() ? "" : ", ") + interval_words(i);
  fmt::print("    holds where a common friction is {}\n", all.empty() ? "nowhere" : all);
  if (const Real cube = cube_bound(*t.region); cube > 0)
    fmt::print("    holds for any mixture of frictions up to {:.4g}\n", cube);
  if (t.index < 0) fmt::print("    index -1: if contacts yield a little this motion is unstable\n");
}

Json pair(Vec2 v) { return Json::array({v.x, v.y}); }

Json json_of(const Grasp& g, const Told& t) {
  Json j{{"mode", t.name}, {"twist", {t.twist.x, t.twist.y, t.twist.z}}};
  j["contacts"] = Json::array();
  for (std::size_t i = 0; i < g.contacts.size(); ++i)
    j["contacts"].push_back({{"finger", g.name(i)},
                             {"does", t.signs.roll >> i & 1                     ? "sticks"
                                      : (t.signs.plus | t.signs.minus) >> i & 1 ? "slides"
                                      : stays(g, t, i)                          ? "stays"
                                                                                : "separates"},
                             {"parting", t.parting[i]},
                             {"slip", t.slip[i]},
                             {"normal_force", t.normal[i]},
                             {"tangent_force", t.tangent[i]}});
  j["boundary"] = t.boundary, j["break_tie"] = t.break_tie;
  j["motion_unique"] = t.motion_unique, j["forces_unique"] = t.forces_unique;
  if (!t.region) return j;
  j["index"] = t.index;
  j["equal_friction"] = Json::array();
  for (const Interval& i : equal_friction(*t.region))
    j["equal_friction"].push_back({i.low, std::isfinite(i.high) ? Json(i.high) : Json(nullptr)});
  const Real cube = cube_bound(*t.region);
  j["any_friction_up_to"] = std::isfinite(cube) ? Json(cube) : Json(nullptr);
  return j;
}

void print_all_json(const Grasp& g, const ModeSet& set, const std::vector<Told>& all,
                    const std::string& running) {
  const Vec3 load = g.plan->load();
  Json j{{"lamina", g.plan->name}, {"load", {load.x, load.y, load.z}}};
  j["contacts"] = Json::array();
  for (std::size_t i = 0; i < g.contacts.size(); ++i)
    j["contacts"].push_back({{"finger", g.name(i)},
                             {"point", pair(g.contacts[i].point)},
                             {"normal", pair(g.contacts[i].normal)},
                             {"velocity", pair(g.contacts[i].velocity)},
                             {"friction", {g.roll[i], g.slide[i]}}});
  j["verdict"] = word_for(set.verdict);
  j["near_singular"] = set.near_singular;
  if (!running.empty()) j["running"] = running;
  j["modes"] = Json::array();
  for (const Told& t : all) j["modes"].push_back(json_of(g, t));
  print_json(j);
}

}  // namespace

int print_modes(const Grasp& g, const ModesChoices& c) {
  ModeSet set;
  find_modes(g.prepared, g.friction(), set);
  const std::vector<Told> all = all_of(g, set);
  if (c.json) {
    print_all_json(g, set, all, c.running);
    return kOk;
  }
  const Vec3 load = g.plan->load();
  fmt::print("{}: {} of {} fingers touch; load {:.4g} N, {:.4g} N, {:.4g} N m about the origin\n",
             bold(printable(g.plan->name)), g.contacts.size(), g.plan->fingers.size(), load.x,
             load.y, load.z);
  for (std::size_t i = 0; i < g.contacts.size(); ++i)
    fmt::print("  mu{} of {}: {}\n", i + 1, printable(g.name(i)),
               g.roll[i] == g.slide[i]
                   ? fmt::format("{:g}", g.roll[i])
                   : fmt::format("{:g} sticking, {:g} sliding", g.roll[i], g.slide[i]));
  if (!c.running.empty()) fmt::print("at {:g} s the run moves it by {}\n", c.at, c.running);
  const bool is_tied = set.verdict == Verdict::unique && all.size() > 1;
  fmt::print("{}\n", is_tied ? "one motion holds, in which a finger may carry force or not: a tie"
                             : sentence_of(set.verdict));
  for (const Told& t : all) print_mode(g, t);
  if (set.near_singular) fmt::print("  near a mode whose forces grow without bound\n");
  fmt::print(
      "R sticks (rolls), S slides, B separates (breaks); + and - slide along the edge, "
      "counter-clockwise of the normal or clockwise\n");
  return kOk;
}

}  // namespace pantin::program
