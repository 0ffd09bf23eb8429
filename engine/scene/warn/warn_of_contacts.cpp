// Warns of bodies that cannot collide with any other, and of bodies that fall for ever.
#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "engine/scene/build/build.hpp"

namespace pantin::detail {
namespace {

constexpr std::size_t kMostKinds = 256;  // of filters; above this number they are not compared

/// Bodies with equal filters.
struct FilterKind {
  std::uint32_t groups, with;
  bool is_dynamic, others, is_sensor;
  std::uint32_t first = 0;  // of its bodies
  std::uint32_t count = 0;
  bool stops = false;  // a body that touches it eventually comes to rest

  bool wants(const FilterKind& other) const { return (with & other.groups) != 0; }
  bool agrees(const FilterKind& other) const { return wants(other) && other.wants(*this); }
};

/// The distinct filters of a scene.
struct Filters {
  static constexpr std::uint32_t kNone = UINT32_MAX;
  std::vector<FilterKind> kinds;
  std::vector<std::uint32_t> kind_of;  // by body; kNone: it does not collide

  explicit Filters(const BuiltScene& built) : kind_of(built.bodies.size(), kNone) {
    std::map<std::tuple<std::uint32_t, std::uint32_t, bool, bool, bool>, std::uint32_t> known;
    for (std::uint32_t i = 0; i < built.bodies.size(); ++i) {
      const Collision* c = built.bodies[i].collision.get();
      if (!c) continue;
      const bool moves = built.is_dynamic(i);
      const auto next = static_cast<std::uint32_t>(kinds.size());
      const auto [it, is_new] =
          known.try_emplace({c->groups, c->with, moves, c->others, c->sensor}, next);
      if (is_new) kinds.push_back({c->groups, c->with, moves, c->others, c->sensor, i});
      kind_of[i] = it->second;
      ++kinds[it->second].count;
    }
  }
};

std::string called(const BuiltBody& body) { return "body \"" + body.name + "\""; }

/// Warns of a filter that matches no other; `nearest` is one that it names without being named in
/// return.
void warn_of_filter(const BuiltScene& built, const Filters& filters, const FilterKind& kind,
                    BuildMessages& messages) {
  const FilterKind* asked = nullptr;
  bool any_other = false;
  for (const FilterKind& other : filters.kinds) {
    if (&other == &kind && kind.count < 2) continue;
    if (!kind.is_dynamic && !other.is_dynamic) continue;
    any_other = true;
    if (kind.agrees(other)) return;
    if (kind.wants(other)) asked = &other;
  }
  if (!any_other) return;
  const BuiltBody& body = built.bodies[kind.first];
  const std::string why = asked
                              ? "its \"with\" includes " + called(built.bodies[asked->first]) +
                                    ", whose own \"with\" excludes it"
                              : std::string("no other body is in a group that its \"with\" names");
  messages.warn(body.at, "filter", called(body) + " collides with nothing: " + why);
}

/// Dynamic bodies that joints, cables and pins connect.
class Islands {
 public:
  explicit Islands(const BuiltScene& built) : parent_(built.bodies.size()) {
    is_held.resize(parent_.size(), false);
    for (std::uint32_t i = 0; i < parent_.size(); ++i) parent_[i] = i;
    each_tie(built, [&](std::uint32_t a, std::uint32_t b) {
      if (built.is_dynamic(a) && built.is_dynamic(b)) join(a, b);
    });
    each_tie(built, [&](std::uint32_t a, std::uint32_t b) {
      if (built.is_dynamic(a) != built.is_dynamic(b))
        is_held[root(built.is_dynamic(a) ? a : b)] = true;
    });
  }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  std::vector<bool> is_held;  // by root

 private:
  template <class Take>
  static void each_tie(const BuiltScene& built, const Take& take) {
    for (const BuiltJoint& j : built.joints) take(j.a, j.b);
    for (const BuiltCable& c : built.cables) {
      std::uint32_t last = c.a;
      for (const BuiltGuide& g : c.guides) take(last, g.body), last = g.body;
      take(last, c.b);
    }
    for (const BuiltPin& p : built.pins) take(p.body, p.to);
    for (const BuiltSurfaceJoint& s : built.surface_joints) take(s.a, s.b);
    for (const BuiltBelt& belt : built.belts)
      for (const std::uint32_t body : belt.bodies) take(belt.bodies[0], body);
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::uint32_t> parent_;
};

/// By filter: whether a body with it is stopped by something it touches.
std::vector<bool> stopped_kinds(const Filters& filters) {
  std::vector<bool> stopped;
  for (const FilterKind& kind : filters.kinds)
    stopped.push_back(
        !kind.is_sensor &&
        std::any_of(filters.kinds.begin(), filters.kinds.end(), [&](const FilterKind& other) {
          return other.stops && kind.agrees(other) &&
                 (!other.is_dynamic || kind.others || other.others);
        }));
  return stopped;
}

/// Marks bodies as held that are supported by held bodies, directly or through others.
void hold_what_rests(const BuiltScene& built, Filters& filters, Islands& islands) {
  const auto count = static_cast<std::uint32_t>(built.bodies.size());
  bool changed = true;
  while (changed) {  // at most once for each filter, and once more
    changed = false;
    const std::vector<bool> stopped = stopped_kinds(filters);
    for (std::uint32_t i = 0; i < count; ++i)
      if (built.is_dynamic(i) && filters.kind_of[i] != Filters::kNone &&
          stopped[filters.kind_of[i]])
        islands.is_held[islands.root(i)] = true;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (filters.kind_of[i] == Filters::kNone) continue;
      FilterKind& kind = filters.kinds[filters.kind_of[i]];
      if (kind.stops || kind.is_sensor) continue;
      if (built.is_dynamic(i) && !islands.is_held[islands.root(i)]) continue;
      kind.stops = changed = true;
    }
  }
}

void warn_of_falls(const BuiltScene& built, Filters& filters, BuildMessages& messages) {
  Islands islands(built);
  hold_what_rests(built, filters, islands);
  const BuiltBody* first = nullptr;
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < built.bodies.size(); ++i)
    if (built.is_dynamic(i) && !islands.is_held[islands.root(i)] &&
        built.bodies[i].body.gravity_scale != 0 && count++ == 0)
      first = &built.bodies[i];
  if (!first) return;
  messages.warn(first->at, "fall",
                called(*first) +
                    (count > 1 ? " and " + std::to_string(count - 1) + " more fall" : " falls") +
                    " forever: no joint, cable or pin leads to a fixed body, and no collider that "
                    "stays in place can stop " +
                    (count > 1 ? "them" : "it"));
}

}  // namespace

void warn_of_contacts(const BuiltScene& built, Vec3 gravity, BuildMessages& messages) {
  Filters filters(built);
  if (filters.kinds.size() > kMostKinds) return;
  for (const FilterKind& kind : filters.kinds)
    if (kind.with != UINT32_MAX) warn_of_filter(built, filters, kind, messages);
  if (gravity != Vec3(0)) warn_of_falls(built, filters, messages);
}

}  // namespace pantin::detail
