#include <cmath>
#include <utility>

#include "engine/base/rotation.hpp"
#include "engine/scene/group_builder.hpp"
#include "engine/scene/place.hpp"

namespace pantin::detail {
namespace {

/// A body as its recipe says, its own frame at `own`.
BuiltBody laid_out(const BodyRecipe& recipe, const ElementId& id, const Pose& own) {
  BuiltBody p;
  p.name = recipe.name, p.at = id, p.mass_properties = &recipe.mass_properties;
  p.solver = recipe.solver ? &*recipe.solver : nullptr;
  p.body.pose = recipe.mass_properties.is_moved ? compose(own, recipe.mass_properties.centre) : own;
  p.body.velocity = recipe.velocity, p.body.angular_velocity = recipe.angular_velocity;
  p.body.mass = recipe.mass_properties.mass, p.body.inertia = recipe.mass_properties.inertia;
  p.body.drag = recipe.drag, p.body.gravity_scale = recipe.gravity_scale;
  p.body.motion = recipe.motion;
  p.collision = recipe.collision ? &*recipe.collision : nullptr;
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

void GroupBuilder::add_body(Element<BodyRecipe> e) { add(laid_out(e.recipe, e.id, e.recipe.pose)); }

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
    // The chain starts as a rigid body rotating about its middle.
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
