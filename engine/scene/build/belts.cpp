// Belts.
#include <algorithm>

#include "engine/scene/build/group_builder.hpp"
#include "engine/scene/build/place.hpp"
#include "engine/world/belt_sides.hpp"

namespace pantin::detail {
namespace {

constexpr int kFewestLinks = 6, kMostLinks = 2000;  // as the key "links" says
constexpr Real kLinkTurn = 0.01;  // rad, between sample points of the route along which links are
                                  // placed

/// The poses of link bodies along a belt, with y along it, and their lengths.
struct LinkLayout {
  std::vector<Pose> poses;
  std::vector<Real> lengths;
};

/// Places links between equidistant points along the belt.
LinkLayout links_along(const Belt& belt, std::span<const Pose> bodies, int count) {
  std::vector<Vec3> way;
  trace_belt(belt, bodies, kLinkTurn, way);
  way.push_back(way.front());
  Real whole = 0;
  for (std::size_t i = 1; i < way.size(); ++i) whole += glm::length(way[i] - way[i - 1]);
  std::vector<Vec3> nodes;
  Real gone = 0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Real length = glm::length(way[i] - way[i - 1]);
    const auto next = [&] { return whole * static_cast<Real>(nodes.size()) / count; };
    while (static_cast<int>(nodes.size()) < count && next() < gone + length)
      nodes.push_back(glm::mix(way[i - 1], way[i], (next() - gone) / length));
    gone += length;
  }
  LinkLayout layout;
  const Real z = to_world(bodies.front(), belt.pulleys.front().anchor).z;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Vec3 from = nodes[i], way_on = nodes[(i + 1) % nodes.size()] - from;
    const Real half = 0.5 * (std::atan2(way_on.y, way_on.x) - kPi / 2);
    const Vec3 middle = from + 0.5 * way_on;
    layout.poses.push_back({{middle.x, middle.y, z}, {std::cos(half), 0, 0, std::sin(half)}});
    layout.lengths.push_back(glm::length(way_on));
  }
  return layout;
}

struct LinkOf {
  std::string name;
  ElementId at;
  Real mass;
};
BuiltBody link_of(const Shape& shape, const LinkOf& of, const Pose& at) {
  BuiltBody link;
  link.name = of.name, link.at = of.at, link.body.pose = at;
  const MassProperties solid = mass_properties(shape, 1);
  const Real density = of.mass / solid.mass;
  BodyMassProperties own;
  own.mass = of.mass, own.shapes = {shape};
  own.inertia = density * Vec3(solid.inertia[0][0], solid.inertia[1][1], solid.inertia[2][2]);
  link.body.mass = own.mass, link.body.inertia = own.inertia;
  link.mass_properties = std::make_shared<const BodyMassProperties>(std::move(own));
  return link;
}

}  // namespace

/// Places the pulleys of a belt on their bodies, all inside the loop; returns false after an error.
bool GroupBuilder::place_pulleys(Element<BeltRecipe> e, BuiltBelt& made) {
  bool moves = false;
  for (const PulleyRecipe& recipe : e.recipe.pulleys) {
    const auto on = body(recipe.body, e.id, "pulleys");
    if (!on) return false;
    const BuiltBody& b = made_.bodies[*on];
    const auto refuse = [&](const std::string& found, const std::string& expected) {
      std::string text = "found ";
      text.append(found).append(", expected ").append(expected);
      messages_.error(e.id, "pulleys", text);
      return false;
    };
    if (std::find(made.bodies.begin(), made.bodies.end(), *on) != made.bodies.end())
      return refuse("two pulleys on " + quoted_name(recipe.body), "one on each body");
    if (b.body.motion == Motion::fixed)
      return refuse("a pulley on " + quoted_name(recipe.body) + ", which is fixed",
                    "a body that rotates: the belt does not slip on it");
    if (b.mass_properties->is_point)
      return refuse("a pulley on the point mass " + quoted_name(recipe.body),
                    "a body with a \"shape\" or an \"inertia\"");
    moves = moves || b.body.motion == Motion::dynamic;
    BeltPulley pulley;
    pulley.anchor = anchor_of(made_, *on, recipe.at);
    pulley.frame = glm::conjugate(b.body.pose.rotation);
    if (recipe.outline.empty()) {
      pulley.outline.radius = recipe.radius;
    } else {
      const Quat own =
          glm::normalize(b.body.pose.rotation * glm::conjugate(b.mass_properties->centre.rotation));
      std::vector<Vec3> corners;
      for (const Vec3& p : recipe.outline) corners.push_back(own * p);
      pulley.outline = hull_outline(corners);
    }
    made.bodies.push_back(*on), made.belt.pulleys.push_back(std::move(pulley));
  }
  if (!moves)
    messages_.error(e.id, "pulleys", "found no pulley on a dynamic body, expected at least one");
  return moves;
}

void GroupBuilder::add_belt(Element<BeltRecipe> e) {
  const BeltRecipe& recipe = e.recipe;
  BuiltBelt made{
      name_for(recipe.name, recipe.pulleys[0].body, recipe.pulleys[1].body), e.id, {}, {}, {}};
  Belt& belt = made.belt;
  belt.friction = recipe.friction, belt.pretension = recipe.pretension;
  belt.width = recipe.width, belt.material = recipe.material;
  if (!place_pulleys(e, made)) return;
  std::vector<Pose> poses;
  for (const std::uint32_t on : made.bodies) poses.push_back(made_.pose_of(on));
  BeltSides sides{{}, recipe.crossed};
  for (const PulleyRecipe& p : recipe.pulleys) sides.is_outside.push_back(p.is_outside);
  const std::string why = lay_round(belt, poses, sides);
  if (!why.empty()) return messages_.error(e.id, "pulleys", "found " + why);
  if (recipe.has_links) return add_links_of_belt(e, made);
  made.laid = poses;
  made_.belts.push_back(std::move(made));
}

/// Whether all pulleys collide; reports one that does not.
bool GroupBuilder::can_be_driven(Element<BeltRecipe> e, const BuiltBelt& laid) {
  for (const std::uint32_t on : laid.bodies) {
    const BuiltBody& b = made_.bodies[on];
    if (b.collision && !b.mass_properties->shapes.empty()) continue;
    messages_.error(e.id, "pulleys",
                    "found links on the pulley " + quoted_name(b.name) +
                        ", which does not collide, expected a shape and \"collision\"");
    return false;
  }
  return true;
}

void GroupBuilder::add_links_of_belt(Element<BeltRecipe> e, const BuiltBelt& laid) {
  const Real thickness = kBeltThickness * laid.belt.width;
  const Real most = laid.belt.length / (1.2 * thickness);
  const int fits_in = static_cast<int>(std::min<Real>(most, 2 * kMostLinks));
  const int count =
      e.recipe.links > 0 ? e.recipe.links : std::clamp(fits_in / 2, kFewestLinks, kMostLinks);
  if (!can_be_driven(e, laid)) return;
  const std::string belt = " a belt " + written(laid.belt.length) + " m long";
  if (fits_in < kFewestLinks)
    return messages_.error(e.id, "width",
                           "found a width of " + written(laid.belt.width) + " m on" + belt +
                               ", expected at most " +
                               written(laid.belt.length / (1.2 * kFewestLinks * kBeltThickness)) +
                               " m: six links of a quarter of it fit in");
  if (count > fits_in)
    return messages_.error(e.id, "links",
                           "found " + std::to_string(count) + " links of" + belt + " and " +
                               written(thickness) + " m thick, expected 6 to " +
                               std::to_string(fits_in));
  BuildCount more;
  more.bodies = more.links = more.parts = count;
  if (!fits(more, e.id)) return;
  context_.used.add(more, 1);
  std::vector<Pose> poses;
  for (const std::uint32_t on : laid.bodies) poses.push_back(made_.pose_of(on));
  const LinkLayout layout = links_along(laid.belt, poses, count);
  const Collision own{.friction = e.recipe.friction, .others = true, .self = true};
  const auto collision = std::make_shared<const Collision>(own);
  const auto first = static_cast<std::uint32_t>(made_.bodies.size());
  for (int i = 0; i < count; ++i) {
    Shape shape;
    shape.kind = ShapeKind::capsule, shape.material = laid.belt.material;
    shape.size = {0.5 * thickness, 0.5 * layout.lengths[i], 0};
    add(link_of(shape, {laid.name + "/" + std::to_string(i), e.id, e.recipe.mass / count},
                layout.poses[i]));
    made_.bodies.back().collision = collision;
  }
  for (int i = 0; i < count; ++i) {
    const auto a = first + static_cast<std::uint32_t>(i),
               b = first + static_cast<std::uint32_t>((i + 1) % count);
    JointRecipe hinge;
    hinge.turn.kind = JointKind::hinge, hinge.axes.axis = {0, 0, 1};
    hinge.anchor = to_world(layout.poses[i], {0, 0.5 * layout.lengths[i], 0});
    made_.joints.push_back({laid.name + "/" + std::to_string(i) + "-" + std::to_string(i + 1), e.id,
                            a, b, joint_of(made_, hinge, a, b)});
  }
}

}  // namespace pantin::detail
