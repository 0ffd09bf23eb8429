// Modes for uncertain friction: probabilities, worst cases, and the smallest displacement of a
// finger that makes a mode certain.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/utf8.hpp"
#include "tools/pantin/modes.hpp"

namespace pantin::program {
namespace {

struct Bounds {
  OwnFriction low{}, high{};
};

/// A region's own coefficients, taken from all.
Bounds own_bounds(const Region& r, std::span<const Spread> spreads) {
  Bounds own;
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.variables()); ++k) {
    own.low[k] = spreads[r.contacts[k]].low;
    own.high[k] = spreads[r.contacts[k]].high;
  }
  return own;
}

WorstCase worst_of(const Region& r, std::span<const Spread> spreads) {
  const Bounds own = own_bounds(r, spreads);
  return worst_case(r, own.low, own.high);
}

/// The mode that is feasible for all coefficients while no other ever is, or -1.
int certain_mode(const Prepared& p, std::span<const Spread> spreads) {
  int found = -1;
  for (std::size_t i = 0; i < p.regions.size(); ++i) {
    const Occurrence o = worst_of(p.regions[i], spreads).occurrence;
    if (o == Occurrence::never) continue;
    if (o != Occurrence::always || found >= 0) return -1;
    found = static_cast<int>(i);
  }
  return found;
}

std::string spread_words(const Spread& s) {
  if (s.kind == Spread::Kind::exact) return fmt::format("{:g}", s.low);
  if (s.kind == Spread::Kind::uniform)
    return fmt::format("{:g} to {:g}, all equally likely", s.low, s.high);
  return fmt::format("{:g} +- {:g}, within {:g} to {:g}", s.mean, s.deviation, s.low, s.high);
}

std::string percent(const Probability& p) {
  return p.samples > 0 ? fmt::format("{:.2f} % +- {:.2f} %", 100 * p.value, 100 * p.error)
                       : fmt::format("{:.4f} %", 100 * p.value);
}

/// How far a finger may move along its edge, m; without an outline half the grasp's size.
Bounds reach_of(const Grasp& g, std::size_t contact) {
  const FingerPlan& f = g.plan->fingers[g.fingers[contact]];
  const auto& outline = g.plan->outline;
  Bounds reach;
  if (outline.empty() || f.flat) {
    reach.low[0] = reach.high[0] = g.prepared.scale / 2;
    return reach;
  }
  const Edge e = edge_of(outline, nearest_edge(outline, f.point, 0).edge);
  const Real along = dot(e.along, f.point - e.from);
  reach.low[0] = along, reach.high[0] = e.length - along;
  return reach;
}

/// A displacement of a finger along its edge, counter-clockwise positive, and the mode that it
/// makes certain.
struct Move {
  std::size_t contact = 0;
  Real by = 0;  // m
  std::string mode, words;
};

/// The mode that is certain after the displacement, or "".
std::string certain_after(const Grasp& g, Move& move) {
  Grasp moved = g;
  Contact& c = moved.contacts[move.contact];
  c.point = c.point + -move.by * tangent_of(c.normal);
  prepare({moved.contacts, g.plan->load()}, moved.prepared);
  const int found = certain_mode(moved.prepared, g.spreads);
  if (found < 0) return "";
  const Region& r = moved.prepared.regions[static_cast<std::size_t>(found)];
  move.words = in_words(g, signs_of(r));
  return name_of(moved.prepared, r);
}

/// The smallest displacement of this finger: steps of a 400th of its reach, refined to a millionth
/// of it.
std::optional<Move> smallest_move(const Grasp& g, std::size_t contact) {
  constexpr int kSteps = 400;
  const Bounds reach = reach_of(g, contact);
  std::optional<Move> best;
  for (const Real way : {1.0, -1.0}) {
    const Real far = way > 0 ? reach.high[0] : reach.low[0];
    for (int i = 1; i < kSteps; ++i) {
      Move move{contact, way * far * i / kSteps, "", ""};
      if (best && std::abs(move.by) >= std::abs(best->by)) break;
      if (certain_after(g, move).empty()) continue;
      Real bad = way * far * (i - 1) / kSteps, good = move.by;
      while (std::abs(good - bad) > 1e-6 * far) {
        Move middle{contact, (good + bad) / 2, "", ""};
        (certain_after(g, middle).empty() ? bad : good) = middle.by;
      }
      move.by = good;
      move.mode = certain_after(g, move);
      best = move;
      break;
    }
  }
  return best;
}

}  // namespace

int print_outlook(const Grasp& g, const ModesChoices& c) {
  const Sampling sampling;
  const Outlook all = outlook(g.prepared, g.spreads, sampling);
  Json j{{"lamina", g.plan->name}, {"modes", Json::array()}};
  if (!c.json) {
    fmt::print("{}\n", bold(printable(g.plan->name)));
    for (std::size_t i = 0; i < g.contacts.size(); ++i)
      fmt::print("  mu{} of {}: {}\n", i + 1, printable(g.name(i)), spread_words(g.spreads[i]));
  }
  for (std::size_t i = 0; i < g.prepared.regions.size(); ++i) {
    const Region& r = g.prepared.regions[i];
    const WorstCase worst = worst_of(r, g.spreads);
    if (worst.occurrence == Occurrence::never) continue;
    const Probability p = probability(r, g.spreads, sampling);
    const std::string name = name_of(g.prepared, r), words = in_words(g, signs_of(r));
    j["modes"].push_back({{"mode", name},
                          {"occurrence", word_for(worst.occurrence)},
                          {"probability", p.value},
                          {"error", p.error}});
    if (worst.occurrence == Occurrence::always)
      j["modes"].back()["largest_normal_force"] = worst.largest_force;
    if (c.json) continue;
    fmt::print("{}  {}: {}; probability {}\n", name, printable(words), word_for(worst.occurrence),
               percent(p));
    if (worst.occurrence == Occurrence::always)
      fmt::print("    largest normal force {:.4g} N, whatever the friction between these bounds\n",
                 worst.largest_force);
  }
  j["none"] = all.none.value, j["unique"] = all.unique.value;
  j["ambiguous"] = all.ambiguous.value, j["samples"] = sampling.count;
  if (c.json) {
    print_json(j);
    return kOk;
  }
  fmt::print("exactly one mode: {}; several: {}; none: {}\n", percent(all.unique),
             percent(all.ambiguous), percent(all.none));
  return kOk;
}

int print_advice(const Grasp& g, const ModesChoices& c) {
  std::optional<Move> best;
  const int now = certain_mode(g.prepared, g.spreads);
  if (now >= 0) {
    const Region& r = g.prepared.regions[static_cast<std::size_t>(now)];
    best = Move{0, 0, name_of(g.prepared, r), in_words(g, signs_of(r))};
  }
  for (std::size_t i = 0; now < 0 && i < g.contacts.size(); ++i) {
    const auto move = smallest_move(g, i);
    if (move && (!best || std::abs(move->by) < std::abs(best->by))) best = move;
  }
  if (c.json) {
    Json j{{"lamina", g.plan->name}, {"certain", best.has_value()}};
    if (best) j["finger"] = g.name(best->contact), j["by"] = best->by, j["mode"] = best->mode;
    print_json(j);
    return kOk;
  }
  if (!best)
    fmt::print("no position of one finger on its edge makes a mode certain\n");
  else if (now >= 0)
    fmt::print("{} is certain as it is: {}\n", best->mode, printable(best->words));
  else
    fmt::print("{} {} by {:.4g} m along its edge, {}: then {} is certain, {}\n", "move",
               printable(g.name(best->contact)), std::abs(best->by),
               best->by > 0 ? "counter-clockwise round the lamina" : "clockwise round the lamina",
               best->mode, printable(best->words));
  return kOk;
}

}  // namespace pantin::program
