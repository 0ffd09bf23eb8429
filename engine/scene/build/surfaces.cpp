// Joints of surfaces in contact.
#include "engine/geometry/shape_skin.hpp"
#include "engine/geometry/surface.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/world/surface_start.hpp"

namespace pantin::detail {

/// The surface of one side in its body's mass-centre frame. Returns false if the body has none.
bool GroupBuilder::place_side(const SurfaceSideRecipe& side, std::uint32_t body,
                              ContactSurface& to) {
  const Pose own = body == kWorldBody ? Pose{} : made_.bodies[body].mass_properties->centre;
  if (side.surface) {
    to.skin = side.surface->skin, to.pose = compose(inverse(own), side.pose.value_or(Pose{}));
    return true;
  }
  if (side.curve) {
    to.curve = side.curve, to.pose = compose(inverse(own), side.pose.value_or(Pose{}));
    return true;
  }
  if (body == kWorldBody) return false;
  for (const Shape& shape : made_.bodies[body].mass_properties->shapes) {
    to.skin = skin_of(shape), to.pose = shape.local;
    if (to.skin) return true;
  }
  return false;
}

void GroupBuilder::add_surface_joint(Element<SurfaceJointRecipe> e) {
  const SurfaceJointRecipe& recipe = e.recipe;
  const auto a = body_or_world(recipe.a.body, e.id, "a/body"),
             b = body_or_world(recipe.b.body, e.id, "b/body");
  if (!a || !b) return;
  if (*a == *b || (!made_.is_dynamic(*a) && !made_.is_dynamic(*b)))
    return messages_.error(e.id, "",
                           "found a surface joint of " + quoted_name(recipe.a.body) + " and " +
                               quoted_name(recipe.b.body) +
                               ", expected two bodies, at least one of them dynamic");
  BuiltSurfaceJoint made{name_for(recipe.name, recipe.a.body, recipe.b.body),
                         e.id,
                         *a,
                         *b,
                         {},
                         recipe.a.curve_name,
                         recipe.b.curve_name};
  SurfaceContact& c = made.contact;
  c.motion = recipe.motion, c.lifts = recipe.lifts, c.on_rim = recipe.on_rim;
  c.friction = recipe.friction.value_or(-1);
  struct Side {
    const SurfaceSideRecipe& recipe;
    std::uint32_t body;
    ContactSurface& to;
    const char* member;
  };
  for (const Side& side : {Side{recipe.a, *a, c.on_a, "a"}, Side{recipe.b, *b, c.on_b, "b"}}) {
    if (side.body != kWorldBody && made_.bodies[side.body].mass_properties->is_point)
      return messages_.error(e.id, side.member,
                             "found the point mass " + quoted_name(side.recipe.body) +
                                 ", expected a body with a \"shape\" or an \"inertia\"");
    if (place_side(side.recipe, side.body, side.to)) continue;
    return messages_.error(
        e.id, side.member,
        "found no smooth shape of " + quoted_name(side.recipe.body) +
            ", expected a \"surface\", a \"curve\", or a sphere, an ellipsoid, a cylinder, "
            "a plane or a NURBS shape");
  }
  c.spots = static_cast<std::uint8_t>(recipe.contacts.value_or(usual_spots(c)));
  if (const std::string why = place_surfaces(c, {made_.pose_of(*a), made_.pose_of(*b)});
      !why.empty()) {
    // "poses" may bring them together.
    SurfaceContact open = c;
    open.lifts = true;
    if (!place_surfaces(open, {made_.pose_of(*a), made_.pose_of(*b)}).empty())
      return messages_.error(e.id, "", why);
    made.apart = why;
  }
  for (const auto& [surface, side] : {std::pair{&c.on_a, "surface a"}, {&c.on_b, "surface b"}})
    if (const std::string crease = crease_between(*surface, side); !crease.empty())
      messages_.warn(e.id, "crease", crease + "; a contact that reaches it is lost");
  if (c.lifts)
    if (const std::string fit = fit_between(c, {made_.pose_of(*a), made_.pose_of(*b)});
        !fit.empty())
      messages_.warn(e.id, "fit",
                     "surface joint " + quoted_name(made.name) + " of " +
                         quoted_name(recipe.a.body) + " and " + quoted_name(recipe.b.body) + ": " +
                         fit);
  made_.surface_joints.push_back(std::move(made));
}

}  // namespace pantin::detail
