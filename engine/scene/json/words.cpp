#include "engine/scene/json/words.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <numeric>
#include <vector>

#include "engine/base/utf8.hpp"

namespace pantin::detail {
namespace {

/// Edits (insert, delete, replace, swap neighbours) from `a` to `b` [Damerau 1964, restricted].
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> two(b.size() + 1), one(b.size() + 1), now(b.size() + 1);
  std::iota(one.begin(), one.end(), std::size_t(0));
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({one[j] + 1, now[j - 1] + 1, one[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], two[j - 2] + 1);
    }
    std::swap(two, one), std::swap(one, now);
  }
  return one[b.size()];
}

/// The least cost charged for a comparison, so that comparing lengths counts as well.
constexpr std::size_t kLookCost = 8;

std::string hint_of(std::string_view best) {
  return best.empty() ? "" : "; nearest is \"" + clipped(best) + "\"";
}

/// Words of other engines and formats, and ours for the same; several rows for a word that has
/// several meanings, of which the one that fits the place is taken.
using Translation = std::pair<std::string_view, std::string_view>;
constexpr Translation kOfJoints[] = {
    {"weld", "fixed"},        {"rigid", "fixed"},      {"lock", "fixed"},
    {"revolute", "hinge"},    {"continuous", "hinge"}, {"rotational", "hinge"},
    {"pin", "hinge"},         {"slider", "prismatic"}, {"slide", "prismatic"},
    {"linear", "prismatic"},  {"spherical", "ball"},   {"socket", "ball"},
    {"point2point", "ball"},  {"point", "ball"},       {"cardan", "universal"},
    {"hooke", "universal"},   {"rope", "cable"},       {"constraints", "joints"},
    {"constraint", "joints"}, {"parent", "a"},         {"child", "b"},
    {"body1", "a"},           {"body2", "b"},          {"body_a", "a"},
    {"body_b", "b"},          {"bodyA", "a"},          {"bodyB", "b"},
    {"pivot", "anchor"},      {"pos", "position"},     {"damper", "damping"},
    {"springs", "spring"},    {"springs", "joints"},   {"actuator", "motor"},
    {"actuators", "motor"},   {"drive", "motor"}};
constexpr Translation kOfBodies[] = {{"static", "fixed"},
                                     {"links", "bodies"},
                                     {"objects", "bodies"},
                                     {"rigidbodies", "bodies"},
                                     {"type", "kind"},
                                     {"kind", "type"},
                                     {"type", "motion"},
                                     {"moving", "dynamic"},
                                     {"animated", "kinematic"},
                                     {"quat", "rotation"},
                                     {"orientation", "rotation"},
                                     {"euler", "rotation_deg"},
                                     {"rpy", "rotation_deg"},
                                     {"origin", "position"},
                                     {"pose", "position"},
                                     {"translation", "position"},
                                     {"linear_velocity", "velocity"},
                                     {"angularVelocity", "angular_velocity"},
                                     {"spin", "angular_velocity"},
                                     {"collision", "shape"},
                                     {"geometry", "shape"},
                                     {"geom", "shape"},
                                     {"geoms", "shapes"},
                                     {"collider", "shape"},
                                     {"colliders", "shapes"},
                                     {"rgba", "colour"},
                                     {"color", "colour"},
                                     {"bounciness", "restitution"},
                                     {"elasticity", "restitution"},
                                     {"cuboid", "box"},
                                     {"cube", "box"},
                                     {"halfspace", "plane"},
                                     {"convex", "hull"},
                                     {"ball", "sphere"},
                                     {"trimesh", "mesh"},
                                     {"heightfield", "height_field"},
                                     {"hfield", "height_field"}};
constexpr Translation kOfScenes[] = {
    {"tendons", "cables"},    {"tendon", "cables"}, {"ropes", "cables"}, {"forces", "events"},
    {"force", "events"},      {"timestep", "step"}, {"dt", "step"},      {"time_step", "step"},
    {"end_time", "duration"}, {"time", "duration"}, {"name", "title"},   {"includes", "prefabs"},
    {"models", "prefabs"}};

}  // namespace

std::string_view called_here(std::string_view word, std::span<const std::string_view> candidates) {
  for (const std::span<const Translation> words :
       {std::span<const Translation>(kOfJoints), std::span<const Translation>(kOfBodies),
        std::span<const Translation>(kOfScenes)})
    for (const auto& [elsewhere, here] : words)
      if (word == elsewhere &&
          std::find(candidates.begin(), candidates.end(), here) != candidates.end())
        return here;
  return {};
}

std::string_view Hints::nearest(std::string_view word,
                                std::span<const std::string_view> candidates) {
  std::string_view best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (std::string_view candidate : candidates) {
    if (left_ < kLookCost) {
      left_ = 0;
      return {};
    }
    left_ -= kLookCost;
    const std::size_t more = std::max(word.size(), candidate.size());
    const std::size_t difference = more - std::min(word.size(), candidate.size());
    if (difference >= least || more > 256) continue;
    left_ -= std::min(left_, (word.size() + 1) * (candidate.size() + 1));
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < least && distance < more) least = distance, best = candidate;
  }
  return best;
}

std::string Hints::of(std::string_view word, std::span<const std::string_view> candidates) {
  return hint_of(nearest(word, candidates));
}

std::string Hints::of_word(std::string_view word, std::span<const std::string_view> candidates) {
  if (const std::string_view here = called_here(word, candidates); !here.empty())
    return "; it is called " + quoted_name(here) + " here";
  return of(word, candidates);
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
  return Hints().nearest(word, candidates);
}

std::string hint(std::string_view word, std::span<const std::string_view> candidates) {
  return hint_of(nearest(word, candidates));
}

std::string quoted_name(std::string_view name) { return "\"" + clipped(name) + "\""; }

std::string written(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", number);
  return text.data();
}

std::string number_text(double number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end.ptr};
}

std::string listed(std::span<const std::string_view> words) {
  std::string whole;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) whole += i + 1 == words.size() ? " or " : ", ";
    whole += words[i];
  }
  return whole;
}

}  // namespace pantin::detail
