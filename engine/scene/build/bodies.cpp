#include <cmath>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/scene/build/place.hpp"

namespace pantin::detail {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;

/// The body of a recipe, with its own frame at `own`.
BuiltBody laid_out(const BodyRecipe& recipe, const ElementId& id, const Pose& own) {
  BuiltBody p;
  p.name = recipe.name, p.at = id, p.mass_properties = of_recipe(recipe.mass_properties);
  p.solver = recipe.solver ? &*recipe.solver : nullptr;
  p.body = recipe.body;
  p.body.pose = recipe.mass_properties.is_moved ? compose(own, recipe.mass_properties.centre) : own;
  p.body.mass = recipe.mass_properties.mass, p.body.inertia = recipe.mass_properties.inertia;
  p.is_lamina = recipe.is_lamina, p.is_finger = recipe.is_finger;
  if (recipe.collision) p.collision = of_recipe(*recipe.collision);
  return p;
}

}  // namespace

std::uint32_t GroupBuilder::add(BuiltBody body) {
  context_.poll();
  const auto place = static_cast<std::uint32_t>(made_.bodies.size());
  made_.bodies.push_back(std::move(body));
  bodies_.emplace(made_.bodies.back().name, place);
  return place;
}

void GroupBuilder::add_body(Element<BodyRecipe> e) {
  add(laid_out(e.recipe, e.id, own_poses_[e.id.index]));
}

/// The index of each body's parent in the recipe, or kNone.
std::vector<std::uint32_t> GroupBuilder::parents_of_bodies() {
  std::vector<std::uint32_t> parents(group_.bodies.size(), kNone);
  std::unordered_map<std::string_view, std::uint32_t> place_of;
  for (std::uint32_t i = 0; i < group_.bodies.size(); ++i) {
    const BodyRecipe& body = group_.bodies[i];
    if (!body.parent) continue;
    if (place_of.empty())
      for (std::uint32_t k = 0; k < group_.bodies.size(); ++k)
        place_of.try_emplace(group_.bodies[k].name, k);
    if (const auto it = place_of.find(*body.parent); it != place_of.end()) {
      parents[i] = it->second;
      continue;
    }
    std::vector<std::string_view> names;
    if (messages_.hints().any_left())
      for (const BodyRecipe& other : group_.bodies) names.push_back(other.name);
    messages_.error({ElementKind::body, number_, i}, "parent",
                    "found " + quoted_name(*body.parent) +
                        ", expected the name of one of the \"bodies\"" +
                        messages_.hints().of(*body.parent, names));
  }
  return parents;
}

/// Reports a cycle of parents once, with the names of its bodies.
void GroupBuilder::tell_of_circle(const std::vector<std::uint32_t>& parents, std::uint32_t start) {
  constexpr int kMostNamed = 20;
  std::string way;
  int named = 0;
  std::uint32_t at = start;
  do {
    if (named++ < kMostNamed) way += group_.bodies[at].name + " -> ";
    at = parents[at];
  } while (at != start);
  messages_.error({ElementKind::body, number_, start}, "parent",
                  "found " + quoted_name(*group_.bodies[start].parent) +
                      ", expected a parent that is not itself placed relative to this body (" +
                      way + (named > kMostNamed ? "... -> " : "") + group_.bodies[start].name +
                      ")");
}

/// Computes the pose of each body of the recipe, parents first.
void GroupBuilder::place_bodies() {
  enum class State : std::uint8_t { unknown, open, done };
  const std::vector<std::uint32_t> parents = parents_of_bodies();
  std::vector<State> states(parents.size(), State::unknown);
  own_poses_.resize(parents.size());
  std::vector<std::uint32_t> way;
  for (std::uint32_t i = 0; i < parents.size(); ++i) {
    std::uint32_t at = i;
    for (; at != kNone && states[at] == State::unknown; at = parents[at])
      states[at] = State::open, way.push_back(at);
    if (at != kNone && states[at] == State::open) tell_of_circle(parents, at);
    for (; !way.empty(); way.pop_back()) {
      const std::uint32_t body = way.back(), parent = parents[body];
      const Pose& own = group_.bodies[body].pose;
      own_poses_[body] = parent == kNone ? own : compose(own_poses_[parent], own);
      if (parent != kNone) own_poses_[body].rotation = glm::normalize(own_poses_[body].rotation);
      states[body] = State::done;
    }
  }
}

void GroupBuilder::add_links_of(Element<ChainRecipe> e) {
  const ChainRecipe& chain = e.recipe;
  first_links_.push_back(static_cast<std::uint32_t>(made_.bodies.size()));
  const ChainLayout layout = layout_of(chain);
  const Vec3 middle = layout.middle();
  Real factor = 1;
  bool is_whole = true;
  for (std::size_t i = 0; i < layout.links.size(); ++i) {
    BuiltBody p = laid_out(chain.link, e.id, layout.links[i]);
    p.name = chain.name + "/" + std::to_string(i);
    const Real own = factor * (i + 1 == layout.links.size() ? chain.tip_mass_factor : 1);
    p.body.mass *= own, p.body.inertia *= own;
    factor *= chain.mass_ratio;
    // The initial motion of the chain is a rigid rotation about its middle.
    p.body.velocity += glm::cross(p.body.angular_velocity, p.body.pose.position - middle);
    if (!chain.materials.empty()) p.material = chain.materials[i % chain.materials.size()];
    if (is_whole && (!std::isfinite(p.body.mass) || !is_possible_inertia(p.body.inertia))) {
      messages_.error(e.id, "",
                      "found a mass of " + written(p.body.mass) + " kg at link " +
                          std::to_string(i) + ", expected a finite mass above 0");
      is_whole = false;
    }
    add(std::move(p));
  }
}

void GroupBuilder::add_drive(Element<PathRecipe> e) {
  const auto place = body(e.recipe.body, e.id, "body");
  if (!place) return;
  BuiltBody& moved = made_.bodies[*place];
  const auto error = [&](const char* expected) {
    messages_.error(e.id, "body", "found " + quoted_name(e.recipe.body) + ", expected " + expected);
  };
  if (moved.body.motion != Motion::kinematic)
    return error("a body whose \"motion\" is \"kinematic\"");
  if (moved.has_path) return error("a body without another path");
  moved.has_path = true;
  const BuiltPath placed{e.id, *place, started(e.recipe.path, moved.body.pose)};
  check_loop(e.id, placed.path);
  moved.body.pose = pose_at(placed.path, 0);
  made_.paths.push_back(placed);
}

void GroupBuilder::add_pose(Element<PoseRecipe> e) {
  const auto place = body(e.recipe.body, e.id, "body");
  if (!place) return;
  const BuiltBody& placed = made_.bodies[*place];
  const auto error = [&](const char* expected) {
    messages_.error(e.id, "body", "found " + quoted_name(e.recipe.body) + ", expected " + expected);
  };
  if (placed.has_path) return error("a body without a path, which determines its pose");
  for (const BuiltPose& other : made_.poses)
    if (other.body == *place) return error("a body without another pose");
  const BodyMassProperties& mass = *placed.mass_properties;
  made_.poses.push_back(
      {e.id, *place, mass.is_moved ? compose(e.recipe.pose, mass.centre) : e.recipe.pose});
}

void GroupBuilder::check_loop(const ElementId& at, const KinematicPath& path) {
  const Pose seam = seam_of(path);
  const Real gap = glm::length(seam.position);
  const Real turn = glm::length(rotation_vector(seam.rotation));
  if (gap > 1e-9 || turn > 1e-6)
    messages_.error(at, "",
                    "found a loop whose last key is " + written(gap) + " m and " +
                        written(turn * 180 / kPi) +
                        " degrees from its first, expected the same pose");
}

}  // namespace pantin::detail
