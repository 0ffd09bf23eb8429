#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/base/rotation.hpp"
#include "engine/scene/read.hpp"

namespace pantin::detail {
PointRecipe read_point(const Reader& from, std::string_view in_scene, std::string_view in_body) {
  return {from.vec_if(in_scene), from.vec_if(in_body)};
}

namespace {

/// The settings of the Lagrangian solver.
void read_exact(const Reader& from, SolverSettings& s) {
  s.integrator =
      static_cast<Integrator>(from.word("integrator", static_cast<std::size_t>(s.integrator)));
  s.stabilisation = static_cast<Stabilisation>(
      from.word("stabilisation", static_cast<std::size_t>(s.stabilisation)));
  s.baumgarte = from.number("baumgarte", s.baumgarte);
  if (from.has("baumgarte") && info_of(s.integrator).baumgarte_is_part && s.baumgarte > 1)
    from.diagnostics.error_value(from.find("baumgarte"),
                                 "a number from 0 to 1: with \"" +
                                     std::string(name_of(s.integrator)) +
                                     "\" it is the part of a gap closed in a step");
  s.step_tolerance = from.number("step_tolerance", s.step_tolerance);
  if (!info_of(s.integrator).takes_tolerance) {
    if (from.has("step_tolerance"))
      from.diagnostics.error_at_key(from.find("step_tolerance"),
                                    std::string("found \"step_tolerance\" with the integrator \"") +
                                        name_of(s.integrator) + "\", expected it with " +
                                        names_that_take_tolerance() +
                                        " only: no other divides steps");
    s.step_tolerance = 0;  // of the settings around it
  }
  s.damping_ratio = from.number("damping_ratio", s.damping_ratio);
}

}  // namespace

std::optional<SolverSettings> read_solver(const Reading& reading, const Reader& outer,
                                          const SolverSettings& base) {
  const NodeId node = outer.find("solver");
  if (node == kNoNode) return std::nullopt;
  const Reader from = reading.open(node, "solver");
  SolverSettings s = base;
  const auto type = from.word("type", static_cast<std::size_t>(s.solver));
  s.solver = static_cast<Solver>(type);
  s.rotation_stiffness = from.number("rotation_stiffness", s.rotation_stiffness);
  s.calm_angle = from.number("calm_angle_deg", s.calm_angle * (180 / kPi)) * (kPi / 180);
  if (!from.has("calm_angle_deg")) s.calm_angle = base.calm_angle;
  s.reservoir_time = from.number("reservoir_time", s.reservoir_time);
  s.active_set_iterations = from.whole("active_set_iterations", s.active_set_iterations);
  s.sleep_speed = from.number("sleep_speed", s.sleep_speed);
  s.sweeps = from.whole("sweeps", s.sweeps);
  s.tolerance = from.number("tolerance", s.tolerance);
  s.stall_drop = from.number("stall_drop", s.stall_drop);
  s.tension_stiffness = from.flag("tension_stiffness", s.tension_stiffness);
  s.limiter = from.flag("limiter", s.limiter);
  s.procedural_reluctance = static_cast<ProceduralReluctance>(
      from.word("procedural_reluctance", static_cast<std::size_t>(s.procedural_reluctance)));
  read_exact(from, s);
  return s;
}

BodyRecipe read_body(const Reading& reading, NodeId node) {
  const Reader from = open_of_class(reading, node, "body");
  BodyRecipe body;
  if (!from.is_object()) return body;
  body.name = from.name();
  body.motion = static_cast<Motion>(from.word("motion"));
  body.mass_properties = read_mass_properties(reading, from, body.motion);
  body.pose = from.pose();
  body.parent = from.reference("parent");
  body.velocity = from.vec("velocity");
  body.angular_velocity = from.vec("angular_velocity");
  if (body.mass_properties.is_point && body.angular_velocity != Vec3(0))
    from.diagnostics.error(from.find("angular_velocity"),
                           "found a point mass that rotates, expected a \"shape\" or an "
                           "\"inertia\" of what turns");
  body.drag = from.number("drag");
  body.gravity_scale = from.number("gravity_scale");
  body.solver = read_solver(reading, from, reading.solver);
  read_collision_of(reading, from, body);
  return body;
}

std::optional<GearRecipe> read_gear(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "gear");
  GearRecipe r;
  r.name = optional_name(from);
  const auto first = from.reference("first");
  const auto second = from.reference("second");
  if (from.has("first_coordinate")) r.first_travels = from.word("first_coordinate", 0) == 1;
  if (from.has("second_coordinate")) r.second_travels = from.word("second_coordinate", 0) == 1;
  r.ratio = from.number("ratio", 1);
  r.in_degrees = from.has("offset_deg");
  if (r.in_degrees)
    r.offset = from.number("offset_deg", 0);
  else if (from.has("offset"))
    r.offset = from.number("offset", 0);
  if (!first || !second) return std::nullopt;
  r.first = *first, r.second = *second;
  return r;
}

namespace {

std::optional<GuideRecipe> read_guide(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "cable_guide");
  GuideRecipe guide;
  const auto body = from.reference("body");
  guide.at = read_point(from, "point", "anchor");
  guide.radius = from.number("radius");
  guide.turns = from.whole("turns");
  guide.axis = from.vec("axis", Vec3(0));
  if (guide.radius > 0 && !(glm::length(guide.axis) > 0))
    reading.diagnostics.error_value(from.has("axis") ? from.find("axis") : node,
                                    "the \"axis\" of a pulley, a vector that is not zero");
  if (!body) return std::nullopt;
  guide.body = *body;
  return guide;
}

}  // namespace

std::optional<CableRecipe> read_cable(const Reading& reading, NodeId node) {
  const Reader from = open_of_class(reading, node, "cable");
  CableRecipe cable;
  cable.name = optional_name(from);
  const auto a = from.reference("a");
  const auto b = from.reference("b");
  cable.at_a = read_point(from, "point_a", "anchor_a");
  cable.at_b = read_point(from, "point_b", "anchor_b");
  if (from.has("length")) cable.length = from.number("length", 1);
  cable.slack = from.number("slack");
  for (const NodeId guide : from.items("over"))
    if (auto read = read_guide(reading, guide)) cable.over.push_back(std::move(*read));
  cable.compliance = from.number("compliance");
  if (!a || !b) return std::nullopt;
  cable.a = *a, cable.b = *b;
  return cable;
}

std::optional<PinRecipe> read_pin(const Reading& reading, NodeId node) {
  const Reader from = open_of_class(reading, node, "pin");
  PinRecipe pin;
  pin.name = optional_name(from);
  const auto body = from.reference("body");
  pin.point = read_point(from, "point", "anchor");
  pin.target = from.vec_if("target");
  pin.anchor_to = from.vec_if("anchor_to");
  pin.to = from.reference("to");
  pin.pin.priority = from.whole("priority");
  pin.pin.kind = static_cast<PinKind>(from.word("kind"));
  pin.pin.stiffness = from.number("stiffness"), pin.pin.damping = from.number("damping");
  if (!body) return std::nullopt;
  pin.body = *body;
  return pin;
}

std::optional<MirrorRecipe> read_mirror(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "mirror");
  MirrorRecipe mirror;
  mirror.plane = {static_cast<int>(from.word("axis")), from.number("offset")};
  mirror.bodies = read_names(reading, from, "bodies");
  return mirror;
}

std::optional<InstanceRecipe> read_instance(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "instance");
  if (!from.is_object()) return std::nullopt;
  InstanceRecipe instance;
  instance.name = from.name();
  const auto prefab = from.reference("prefab");
  instance.pose = from.pose();
  instance.parent = from.reference("parent");
  instance.time_offset = from.number("time_offset");
  instance.solver = read_solver(reading, from, reading.solver);
  if (from.has("mirror")) instance.mirror = static_cast<int>(from.word("mirror", 0));
  if (prefab) instance.prefab = *prefab;
  return instance;
}

std::optional<GridRecipe> read_grid(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "grid");
  if (!from.is_object()) return std::nullopt;
  GridRecipe grid;
  grid.each.name = from.name();
  const auto prefab = from.reference("prefab");
  grid.each.pose = from.pose();
  grid.each.parent = from.reference("parent");
  grid.each.time_offset = from.number("time_offset");
  grid.each.solver = read_solver(reading, from, reading.solver);
  grid.spacing = from.vec("spacing");
  Real n[3] = {0, 0, 0};
  if (from.numbers("count", n)) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (n[i] != std::floor(n[i]))
        reading.diagnostics.error_value(from.find("count"), "whole numbers");
      grid.count[i] = static_cast<int>(n[i]);
    }
  }
  if (from.has("mirror")) grid.each.mirror = static_cast<int>(from.word("mirror", 0));
  if (prefab) grid.each.prefab = *prefab;
  return grid;
}

}  // namespace pantin::detail
