#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/base/rotation.hpp"
#include "engine/scene/read.hpp"

namespace pantin::detail {
namespace {

constexpr std::string_view kSolverNames[] = {"auto", "sweep", "shake2", "paper", "lagrangian"};
constexpr std::string_view kStabilisations[] = {"projection", "baumgarte", "none"};
constexpr std::string_view kReluctances[] = {"inertia_over_mass", "literal_step"};
constexpr std::string_view kMotions[] = {"dynamic", "fixed", "driven"};
constexpr std::string_view kGrips[] = {"exact", "spring"};

PointRecipe read_point(const Reader& from, std::string_view in_scene, std::string_view in_body) {
  const std::string_view both[] = {in_scene, in_body};
  from.one_of(both);
  return {from.vec_if(in_scene), from.vec_if(in_body)};
}

Vec3 degrees(const Reader& from, std::string_view key) {
  return from.vec_or_number(key, Vec3(0)) * (kPi / 180);
}

std::optional<KeyRecipe> read_key(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "keyframe");
  if (from.need("time", "a time in seconds") == kNoNode) return std::nullopt;
  KeyRecipe key;
  key.time = from.number("time", std::numeric_limits<Real>::quiet_NaN(), kTime);
  key.position = from.vec_if("position");
  if (from.has("rotation") || from.has("rotation_deg")) key.rotation = from.rotation(kIdentity);
  if (std::isnan(key.time)) return std::nullopt;
  return key;
}

void read_keys(const Reading& reading, const Reader& from, PathRecipe& drive) {
  const std::vector<NodeId> nodes = from.items("keyframes");
  for (NodeId node : nodes) {
    const auto key = read_key(reading, node);
    if (!key) continue;
    if (!drive.keys.empty() && !(key->time > drive.keys.back().time))
      reading.diagnostics.error(node, "found time " + written(key->time) + " after " +
                                          written(drive.keys.back().time) +
                                          ", expected a later one");
    drive.keys.push_back(*key);
  }
  const std::size_t least = drive.loop ? 2 : 1;
  if (nodes.size() < least)
    reading.diagnostics.error_value(from.find("keyframes"), drive.loop
                                                                ? "two keyframes or more for a loop"
                                                                : "one keyframe or more");
}

void read_sway(const Reading& reading, const Reader& drive_from, PathRecipe& drive) {
  const Reader from = reading.open(drive_from.find("lissajous"), "lissajous");
  drive.centre = from.vec_if("centre");
  drive.sway.amplitude = from.vec("amplitude", Vec3(0));
  drive.sway.frequency = from.vec_or_number("frequency", Vec3(0));
  drive.sway.phase = degrees(from, "phase_deg");
  drive.sway.turn_amplitude = from.vec("rotation_deg", Vec3(0), kDegrees) * (kPi / 180);
  drive.sway.turn_frequency = from.vec_or_number("rotation_frequency", drive.sway.frequency);
  drive.sway.turn_phase = degrees(from, "rotation_phase_deg");
  drive.sway.rise = from.number("rise", 0, kNotNegative);
  if (drive_from.has("loop"))
    reading.diagnostics.error_at_key(drive_from.find("loop"),
                                     "found \"loop\" beside \"lissajous\", expected it with "
                                     "\"keyframes\" only: this curve repeats by itself");
}

/// The settings of the Lagrangian solver.
void read_exact(const Reader& from, SolverSettings& s) {
  s.integrator = static_cast<Integrator>(
      from.word("integrator", static_cast<std::size_t>(s.integrator), kIntegratorNames));
  s.stabilisation = static_cast<Stabilisation>(
      from.word("stabilisation", static_cast<std::size_t>(s.stabilisation), kStabilisations));
  s.baumgarte = from.number("baumgarte", s.baumgarte, kNotNegative);
  if (from.has("baumgarte") && info_of(s.integrator).baumgarte_is_part && s.baumgarte > 1)
    from.diagnostics.error_value(from.find("baumgarte"),
                                 "a number from 0 to 1: with \"" +
                                     std::string(name_of(s.integrator)) +
                                     "\" it is the part of a gap closed in a step");
  s.step_tolerance = from.number("step_tolerance", s.step_tolerance, kPositive);
  if (!info_of(s.integrator).takes_tolerance) {
    if (from.has("step_tolerance"))
      from.diagnostics.error_at_key(from.find("step_tolerance"),
                                    std::string("found \"step_tolerance\" with the integrator \"") +
                                        name_of(s.integrator) + "\", expected it with \"" +
                                        name_of(kTakesTolerance) +
                                        "\" only: no other divides steps");
    s.step_tolerance = 0;  // of the settings around it
  }
  s.damping_ratio = from.number("damping_ratio", s.damping_ratio, kUnit);
}

}  // namespace

std::optional<SolverSettings> read_solver(const Reading& reading, const Reader& outer,
                                          const SolverSettings& base) {
  const NodeId node = outer.find("solver");
  if (node == kNoNode) return std::nullopt;
  const Reader from = reading.open(node, "solver");
  SolverSettings s = base;
  const auto type = from.word("type", static_cast<std::size_t>(s.solver), kSolverNames);
  s.solver = static_cast<Solver>(type);
  s.rotation_stiffness = from.number("rotation_stiffness", s.rotation_stiffness, kNotNegative);
  s.calm_angle = from.number("calm_angle_deg", s.calm_angle * (180 / kPi), kPositive) * (kPi / 180);
  if (!from.has("calm_angle_deg")) s.calm_angle = base.calm_angle;
  s.reservoir_time = from.number("reservoir_time", s.reservoir_time, kNotNegative);
  s.active_set_iterations = from.whole("active_set_iterations", s.active_set_iterations, 1, 64);
  s.sleep_speed = from.number("sleep_speed", s.sleep_speed, kNotNegative);
  s.sweeps = from.whole("sweeps", s.sweeps, 1, 10'000);
  s.tolerance = from.number("tolerance", s.tolerance, kPositive);
  s.stall_drop = from.number("stall_drop", s.stall_drop, kUnit);
  s.tension_stiffness = from.flag("tension_stiffness", s.tension_stiffness);
  s.limiter = from.flag("limiter", s.limiter);
  s.paper_reluctance = static_cast<PaperReluctance>(
      from.word("paper_reluctance", static_cast<std::size_t>(s.paper_reluctance), kReluctances));
  read_exact(from, s);
  return s;
}

std::optional<std::string> read_reference(const Reader& from, std::string_view key,
                                          std::string_view expected, bool is_needed) {
  const NodeId node = is_needed ? from.need(key, expected) : from.find(key);
  if (node == kNoNode) return std::nullopt;
  if (from.json[node].kind == JsonKind::string && !from.json[node].text.empty())
    return std::string(from.json[node].text);
  from.diagnostics.error_value(node, expected);
  return std::nullopt;
}

BodyRecipe read_body(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "body");
  BodyRecipe body;
  if (!from.is_object()) return body;
  body.name = from.name();
  body.motion = static_cast<Motion>(from.word("motion", 0, kMotions));
  body.mass_properties = read_mass_properties(reading, from, body.motion);
  body.pose = from.pose();
  body.velocity = from.vec("velocity", Vec3(0));
  body.angular_velocity = from.vec("angular_velocity", Vec3(0));
  body.drag = from.number("drag", body.drag, kNotNegative);
  body.gravity_scale = from.number("gravity_scale", 1, kAnyNumber);
  body.solver = read_solver(reading, from, reading.solver);
  const bool has_shapes = from.has("shape") || from.has("shapes");
  body.collision = read_collision(reading, from, has_shapes, reading.collision);
  return body;
}

std::optional<GearRecipe> read_gear(const Reading& reading, NodeId node) {
  constexpr std::string_view kMoves[] = {"angle", "travel"};
  constexpr std::string_view kOffsets[] = {"offset", "offset_deg"};
  const Reader from = reading.open(node, "gear");
  GearRecipe r;
  r.name = optional_name(from);
  const auto first = read_reference(from, "first", "the name of a joint", true);
  const auto second = read_reference(from, "second", "the name of a joint", true);
  if (from.has("first_coordinate")) r.first_travels = from.word("first_coordinate", 0, kMoves) == 1;
  if (from.has("second_coordinate"))
    r.second_travels = from.word("second_coordinate", 0, kMoves) == 1;
  const NodeId ratio = from.need("ratio", "how far the second moves for each unit of the first");
  r.ratio = from.number("ratio", 1, kAnyNumber);
  if (ratio != kNoNode && r.ratio == 0)
    from.diagnostics.error_value(ratio, "a number other than 0");
  from.one_of(kOffsets);
  r.in_degrees = from.has("offset_deg");
  if (r.in_degrees)
    r.offset = from.number("offset_deg", 0, kDegrees);
  else if (from.has("offset"))
    r.offset = from.number("offset", 0, kAnyNumber);
  if (!first || !second) return std::nullopt;
  r.first = *first, r.second = *second;
  return r;
}

std::optional<CableRecipe> read_cable(const Reading& reading, NodeId node) {
  constexpr std::string_view kLengths[] = {"length", "slack"};
  const Reader from = reading.open(node, "cable");
  CableRecipe cable;
  cable.name = optional_name(from);
  const auto a = read_reference(from, "a", kBodyOrWorld, true);
  const auto b = read_reference(from, "b", kBodyOrWorld, true);
  cable.at_a = read_point(from, "point_a", "anchor_a");
  cable.at_b = read_point(from, "point_b", "anchor_b");
  from.one_of(kLengths);
  if (from.has("length")) cable.length = from.number("length", 1, kSize);
  cable.slack = from.number("slack", 1, kPositive);
  cable.compliance = from.number("compliance", 0, kNotNegative);
  if (!a || !b) return std::nullopt;
  cable.a = *a, cable.b = *b;
  return cable;
}

std::optional<PinRecipe> read_pin(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "pin");
  PinRecipe pin;
  pin.name = optional_name(from);
  const auto body = read_reference(from, "body", "the name of a body", true);
  pin.point = read_point(from, "point", "anchor");
  constexpr std::string_view kGoals[] = {"target", "anchor_to"};
  from.one_of(kGoals);
  pin.target = from.vec_if("target");
  pin.anchor_to = from.vec_if("anchor_to");
  pin.to = read_reference(from, "to", "the name of a body", false);
  if (pin.anchor_to && !from.has("to"))
    reading.diagnostics.error_at_key(
        from.find("anchor_to"), "found \"anchor_to\" without \"to\", expected the body it lies in");
  pin.pin.priority = from.whole("priority", 0, -1'000'000, 1'000'000);
  pin.pin.grip = static_cast<Grip>(from.word("grip", 0, kGrips));
  pin.pin.stiffness = from.number("stiffness", pin.pin.stiffness, kPositive);
  if (!body) return std::nullopt;
  pin.body = *body;
  return pin;
}

std::optional<PathRecipe> read_path(const Reading& reading, NodeId node) {
  constexpr std::string_view kPaths[] = {"keyframes", "lissajous"};
  const Reader from = reading.open(node, "path");
  PathRecipe drive;
  const auto body = read_reference(from, "body", "the name of a driven body", true);
  from.one_of(kPaths);
  drive.loop = from.flag("loop", false);
  if (from.has("lissajous"))
    read_sway(reading, from, drive);
  else if (from.need("keyframes", "\"keyframes\" or \"lissajous\"") != kNoNode)
    read_keys(reading, from, drive);
  if (!body) return std::nullopt;
  drive.body = *body;
  return drive;
}

std::optional<InstanceRecipe> read_instance(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "instance");
  if (!from.is_object()) return std::nullopt;
  InstanceRecipe instance;
  instance.name = from.name();
  const auto prefab = read_reference(from, "prefab", "the name of a prefab", true);
  instance.pose = from.pose();
  instance.time_offset = from.number("time_offset", 0, kTime);
  instance.solver = read_solver(reading, from, reading.solver);
  if (prefab) instance.prefab = *prefab;
  return instance;
}

std::optional<GridRecipe> read_grid(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "grid");
  if (!from.is_object()) return std::nullopt;
  GridRecipe grid;
  grid.each.name = from.name();
  const auto prefab = read_reference(from, "prefab", "the name of a prefab", true);
  grid.each.pose = from.pose();
  grid.each.time_offset = from.number("time_offset", 0, kTime);
  grid.each.solver = read_solver(reading, from, reading.solver);
  grid.spacing = from.vec("spacing", grid.spacing);
  const NodeId count = from.need("count", "how many copies along x, y and z");
  Real n[3] = {0, 0, 0};
  constexpr Range kCopies{1, 1e6, "a whole number from 1 to 1000000"};
  if (count != kNoNode && read_numbers(reading.json, reading.diagnostics, count, n, kCopies)) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (n[i] != std::floor(n[i])) reading.diagnostics.error_value(count, "whole numbers");
      grid.count[i] = static_cast<int>(n[i]);
    }
  }
  if (prefab) grid.each.prefab = *prefab;
  return grid;
}

}  // namespace pantin::detail
