#include <utility>

#include "engine/joints/kinds.hpp"
#include "engine/scene/build/cable_route.hpp"
#include "engine/scene/build/group_builder.hpp"
#include "engine/scene/build/place.hpp"

namespace pantin::detail {

/// The two sides of a joint or a cable.
struct GroupBuilder::Ends {
  ElementId id;
  const std::string &a_name, &b_name;
  std::uint32_t a, b;
};

/// Reports a joint or cable that cannot connect these two.
bool GroupBuilder::can_tie(const Ends& ends) {
  const char* fault = nullptr;
  if (ends.a == ends.b)
    fault = "expected two different ones";
  else if (!made_.is_dynamic(ends.a) && !made_.is_dynamic(ends.b))
    fault = "expected a dynamic body on one side";
  if (!fault) return true;
  messages_.error(
      ends.id, "",
      "found " + quoted_name(ends.a_name) + " tied to " + quoted_name(ends.b_name) + ", " + fault);
  return false;
}

/// Reports a point mass that is held at a point other than its centre.
bool GroupBuilder::can_hold(const ElementId& id, std::string_view member, std::uint32_t body,
                            Vec3 anchor) {
  constexpr Real kAtCentre = 1e-9;  // m
  if (body == kWorldBody || !made_.bodies[body].mass_properties->is_point) return true;
  if (glm::length(anchor) <= kAtCentre) return true;
  messages_.error(id, member,
                  "found a point " + written(glm::length(anchor)) + " m from the point mass " +
                      quoted_name(made_.bodies[body].name) +
                      ", expected its centre, or a body with a \"shape\" or an \"inertia\"");
  return false;
}

/// Reports a joint that exerts torque on a point mass.
bool GroupBuilder::can_turn(const ElementId& id, const BuiltJoint& j, std::uint32_t body) {
  const Joint& joint = j.joint;
  if (body == kWorldBody || !made_.bodies[body].mass_properties->is_point) return true;
  const bool is_ball = joint.kind == JointKind::ball && !joint.limits.any() && !j.drive;
  if (is_ball || info_of(joint.kind).is_line) return true;
  messages_.error(id, "kind",
                  "found " + a_joint(joint.kind) +
                      (joint.kind == JointKind::ball ? " with limits or a drive" : "") +
                      " at the point mass " + quoted_name(made_.bodies[body].name) +
                      ", expected a ball, a distance or a spring, or a body with a \"shape\" or an "
                      "\"inertia\"");
  return false;
}

void GroupBuilder::add_joint(Element<JointRecipe> e) {
  const JointRecipe& recipe = e.recipe;
  const auto a = body_or_world(recipe.a, e.id, "a"), b = body_or_world(recipe.b, e.id, "b");
  if (!a || !b || !can_tie({e.id, recipe.a, recipe.b, *a, *b})) return;
  BuiltJoint placed{name_for(recipe.name, recipe.a, recipe.b),
                    e.id,
                    *a,
                    *b,
                    joint_of(made_, recipe, *a, *b),
                    recipe.turn.drive};
  for (const std::uint32_t end : {*a, *b})
    if (!can_turn(e.id, placed, end)) return;
  if (!can_hold(e.id, "", *a, placed.joint.anchor_a) ||
      !can_hold(e.id, "", *b, placed.joint.anchor_b))
    return;
  const Parameter* measured = info_of(placed.joint.kind).measured();
  if (measured && !recipe.turn.length && !(measured->value(placed.joint.parameters.edit()) > 0))
    messages_.error(e.id, "",
                    "found " + a_joint(placed.joint.kind) +
                        " whose ends start at one point, expected a \"" +
                        std::string(measured->key) + "\"");
  made_.joints.push_back(std::move(placed));
}

/// Whether a gear couples the travel of a joint: as the file says, or its only coordinate. Reports
/// a joint without that coordinate.
bool GroupBuilder::slides(const std::optional<bool>& asked, std::uint32_t joint,
                          const Wanted& place) {
  const JointKind kind = made_.joints[joint].joint.kind;
  const bool turns = info_of(kind).is_used(Coordinate::angle, kGeared);
  const bool can_slide = info_of(kind).is_used(Coordinate::travel, kGeared);
  const bool slides = asked.value_or(can_slide && !turns);
  if (slides ? can_slide : turns) return slides;
  messages_.error(
      place.from, place.member,
      "found the " + std::string(slides ? "travel" : "angle") + " of " + a_joint(kind) +
          ", expected a joint that " + (slides ? "translates: " : "rotates about one axis: ") +
          kinds_where([&](const JointKindInfo& info) {
            return info.is_used(slides ? Coordinate::travel : Coordinate::angle, kGeared);
          }));
  return slides;
}

void GroupBuilder::add_gear(Element<GearRecipe> e) {
  const GearRecipe& recipe = e.recipe;
  if (joints_.empty())  // all joints exist now
    for (std::uint32_t i = 0; i < made_.joints.size(); ++i)
      joints_.emplace(made_.joints[i].name, i);
  const Wanted at_first{e.id, "first", "the name of a joint"},
      at_second{e.id, "second", "the name of a joint"};
  const auto first = look_up(joints_, recipe.first, at_first),
             second = look_up(joints_, recipe.second, at_second);
  if (!first || !second) return;
  if (*first == *second) {
    messages_.error(
        e.id, "second",
        "found " + quoted_name(recipe.second) + ", expected a joint other than the first");
    return;
  }
  BuiltGear placed{name_for(recipe.name, recipe.first, recipe.second), e.id, *first, *second, {}};
  Gear& r = placed.ratio;
  r.first_travels = slides(recipe.first_travels, *first, at_first);
  r.second_travels = slides(recipe.second_travels, *second, at_second);
  r.ratio = recipe.ratio, r.has_offset = recipe.offset.has_value();
  r.offset = recipe.offset.value_or(0);
  if (r.second_travels) r.ratio *= recipe.length_unit, r.offset *= recipe.length_unit;
  if (r.first_travels) r.ratio /= recipe.length_unit;
  if (recipe.in_degrees && r.second_travels)
    messages_.error(e.id, "", "found \"offset_deg\" of a travel, expected \"offset\" in m");
  made_.gears.push_back(std::move(placed));
}

void GroupBuilder::add_joints_of(Element<ChainRecipe> e) {
  const ChainRecipe& chain = e.recipe;
  const ChainLayout layout = layout_of(chain);
  const auto attach = [&](const std::optional<std::string>& to, const char* member,
                          const char* name, ChainEnd end) {
    const auto body = to ? body_or_world(*to, e.id, member) : std::nullopt;
    if (!body) return;
    end.body = *body;
    if (*body == end.link)
      messages_.error(e.id, member,
                      "found " + quoted_name(*to) + ", expected a body other than the link itself");
    else
      made_.joints.push_back({chain.name + "/" + name, e.id, end.body, end.link,
                              chain_end_joint(made_, chain.turn, end), chain.turn.drive});
  };
  // Anchors are computed in the links' own frames, so that equal links agree bit for bit.
  const std::uint32_t first = first_links_[e.id.index];
  const auto links = static_cast<std::uint32_t>(chain.links);
  const auto end_of = [&](std::uint32_t i, Real side) {
    return from_own_frame(made_, first, {0, side * layout.lengths[i] / 2, 0});
  };
  attach(chain.attach, "attach", "top", {0, first, layout.joints.front(), end_of(0, 1)});
  Joint joint = chain_joint(made_, chain.turn, first);
  const auto tie = [&](std::uint32_t a, std::uint32_t b, const std::optional<JointDrive>& drive) {
    context_.poll();
    joint.anchor_a = end_of(a, -1), joint.anchor_b = end_of(b, 1);
    made_.joints.push_back({chain.name + "/" + std::to_string(a) + "-" + std::to_string(b), e.id,
                            first + a, first + b, joint, drive});
  };
  for (std::uint32_t i = 1; i < links; ++i) tie(i - 1, i, chain.turn.drive);
  if (chain.closed) {
    // A joint that closes a loop constrains its point only, hence a ball joint.
    joint.kind = JointKind::ball, joint.limits = {}, joint.parameters = {};
    tie(links - 1, 0, std::nullopt);
  }
  attach(chain.end_attach, "end_attach", "end",
         {0, first + links - 1, layout.joints.back(), end_of(links - 1, -1)});
}

void GroupBuilder::add_cable(Element<CableRecipe> e) {
  const CableRecipe& recipe = e.recipe;
  const auto a = body_or_world(recipe.a, e.id, "a"), b = body_or_world(recipe.b, e.id, "b");
  if (!a || !b) return;
  if (!recipe.over.empty()) return add_cable_over(e, *a, *b);
  if (!can_tie({e.id, recipe.a, recipe.b, *a, *b})) return;
  CableParameters joint;
  joint.anchor_a = anchor_of(made_, *a, recipe.at_a);
  joint.anchor_b = anchor_of(made_, *b, recipe.at_b);
  if (!can_hold(e.id, "", *a, joint.anchor_a) || !can_hold(e.id, "", *b, joint.anchor_b)) return;
  joint.compliance = recipe.compliance;
  const Real span =
      glm::length(to_scene(made_, *b, joint.anchor_b) - to_scene(made_, *a, joint.anchor_a));
  joint.length = recipe.length.value_or(recipe.slack * span);
  if (!(joint.length > 0)) {
    messages_.error(e.id, "", "found a cable whose ends start at one point, expected a \"length\"");
    return;
  }
  made_.cables.push_back({name_for(recipe.name, recipe.a, recipe.b), e.id, *a, *b, joint});
}

/// A cable over guides. Both ends may be on one body, and neither needs to be dynamic.
void GroupBuilder::add_cable_over(Element<CableRecipe> e, std::uint32_t a, std::uint32_t b) {
  const CableRecipe& recipe = e.recipe;
  BuiltCable made{name_for(recipe.name, recipe.a, recipe.b), e.id, a, b, {}};
  made.joint.anchor_a = anchor_of(made_, a, recipe.at_a);
  made.joint.anchor_b = anchor_of(made_, b, recipe.at_b);
  made.joint.compliance = recipe.compliance;
  bool moves = made_.is_dynamic(a) || made_.is_dynamic(b);
  for (const GuideRecipe& g : recipe.over) {
    const auto body = body_or_world(g.body, e.id, "over");
    if (!body) return;
    moves = moves || made_.is_dynamic(*body);
    BuiltGuide guide{*body,
                     {.body = {}, .anchor = anchor_of(made_, *body, g.at), .radius = g.radius}};
    if (g.radius > 0)
      guide.guide.axis =
          glm::normalize(glm::conjugate(made_.pose_of(*body).rotation) * glm::normalize(g.axis));
    guide.guide.wrap += 2 * kPi * g.turns;
    made.guides.push_back(guide);
  }
  if (!moves)
    return messages_.error(e.id, "", "found a cable without a dynamic body, expected at least one");
  if (made.guides.size() + 2 > kMostPathPoints)
    return messages_.error(e.id, "over",
                           "found " + std::to_string(made.guides.size()) + " guides, expected " +
                               std::to_string(kMostPathPoints - 2) + " at most");
  const std::vector<PathPoint> route = route_of(made_, made);
  if (const std::string fault = fault_in(route); !fault.empty())
    return messages_.error(e.id, "over", fault);
  made.joint.length = recipe.length.value_or(recipe.slack * path_length(route, {}).length);
  made_.cables.push_back(std::move(made));
}

void GroupBuilder::add_pin(Element<PinRecipe> e) {
  const PinRecipe& recipe = e.recipe;
  const auto held = body(recipe.body, e.id, "body");
  if (!held) return;
  if (!made_.is_dynamic(*held)) {
    messages_.error(e.id, "body",
                    "found " + quoted_name(recipe.body) +
                        ", expected a dynamic body: this one is not moved by pins");
    return;
  }
  BuiltPin placed{recipe.name, e.id, *held, recipe.pin};
  placed.pin.anchor = anchor_of(made_, *held, recipe.point);
  if (!can_hold(e.id, "anchor", *held, placed.pin.anchor)) return;
  placed.pin.target = recipe.target.value_or(to_scene(made_, *held, placed.pin.anchor));
  if (recipe.to && !hold_on(e, placed)) return;
  placed.name = name_for(recipe.name, recipe.body, "pin");
  made_.pins.push_back(std::move(placed));
}

/// Transforms a pin's target into the frame of the other body.
bool GroupBuilder::hold_on(Element<PinRecipe> e, BuiltPin& placed) {
  const PinRecipe& recipe = e.recipe;
  const auto to = body(*recipe.to, e.id, "to");
  if (!to) return false;
  placed.to = *to;
  placed.pin.target = recipe.anchor_to ? from_own_frame(made_, *to, *recipe.anchor_to)
                                       : from_scene(made_, *to, placed.pin.target);
  if (*to != placed.body) return true;
  messages_.error(
      e.id, "to",
      "found " + quoted_name(*recipe.to) + ", expected a body other than the pinned one");
  return false;
}

}  // namespace pantin::detail
