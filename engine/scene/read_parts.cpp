#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "engine/base/rotation.hpp"
#include "engine/scene/read.hpp"

namespace pantin {
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
  if (from.has("rotation") || from.has("rotation_deg")) key.rotation = from.rotation(kNoTurn);
  if (std::isnan(key.time)) return std::nullopt;
  return key;
}

void read_keys(const Reading& reading, const Reader& from, DriveRecipe& drive) {
  const std::vector<NodeId> nodes = from.items("keyframes");
  for (NodeId node : nodes) {
    const auto key = read_key(reading, node);
    if (!key) continue;
    if (!drive.keys.empty() && !(key->time > drive.keys.back().time))
      reading.complaints.refuse(node, "found time " + written(key->time) + " after " +
                                          written(drive.keys.back().time) +
                                          ", expected a later one");
    drive.keys.push_back(*key);
  }
  const std::size_t least = drive.loop ? 2 : 1;
  if (nodes.size() < least)
    reading.complaints.refuse_value(from.find("keyframes"), drive.loop
                                                                ? "two keyframes or more for a loop"
                                                                : "one keyframe or more");
}

void read_sway(const Reading& reading, const Reader& drive_from, DriveRecipe& drive) {
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
    reading.complaints.refuse_key(drive_from.find("loop"),
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
    from.complaints.refuse_value(
        from.find("baumgarte"),
        "a number from 0 to 1: with \"" + std::string(name_of(s.integrator)) +
            "\" it is the part of a gap closed in a step");
  s.step_tolerance = from.number("step_tolerance", s.step_tolerance, kPositive);
  if (!info_of(s.integrator).takes_tolerance) {
    if (from.has("step_tolerance"))
      from.complaints.refuse_key(from.find("step_tolerance"),
                                 std::string("found \"step_tolerance\" with the integrator \"") +
                                     name_of(s.integrator) +
                                     "\", expected it with \"" + name_of(kTakesTolerance) +
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
  s.turn_stiffness = from.number("rotation_stiffness", s.turn_stiffness, kNotNegative);
  s.calm_angle = from.number("calm_angle_deg", s.calm_angle * (180 / kPi), kPositive) * (kPi / 180);
  if (!from.has("calm_angle_deg")) s.calm_angle = base.calm_angle;
  s.reservoir_time = from.number("reservoir_time", s.reservoir_time, kNotNegative);
  s.passes = from.whole("active_set_iterations", s.passes, 1, 64);
  s.rest_speed = from.number("sleep_speed", s.rest_speed, kNotNegative);
  s.rounds = from.whole("sweeps", s.rounds, 1, 10'000);
  s.tolerance = from.number("tolerance", s.tolerance, kPositive);
  s.stall_drop = from.number("stall_drop", s.stall_drop, kUnit);
  s.tension_stiffness = from.flag("tension_stiffness", s.tension_stiffness);
  s.limiter = from.flag("limiter", s.limiter);
  s.paper_reluctance = static_cast<PaperReluctance>(
      from.word("paper_reluctance", static_cast<std::size_t>(s.paper_reluctance), kReluctances));
  read_exact(from, s);
  return s;
}

std::optional<Reference> read_reference(const Reader& from, std::string_view key,
                                        std::string_view expected, bool is_needed) {
  const NodeId node = is_needed ? from.need(key, expected) : from.find(key);
  if (node == kNoNode) return std::nullopt;
  if (from.json[node].kind == JsonKind::string && !from.json[node].text.empty())
    return Reference{from.json[node].text, node};
  from.complaints.refuse_value(node, expected);
  return std::nullopt;
}

BodyRecipe read_body(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "body");
  BodyRecipe body;
  body.at = node;
  if (!from.is_object()) return body;
  body.name = from.name();
  body.motion = static_cast<Motion>(from.word("motion", 0, kMotions));
  body.matter = read_matter(reading, from, body.motion);
  body.pose = from.pose();
  body.velocity = from.vec("velocity", Vec3(0));
  body.spin = from.vec("angular_velocity", Vec3(0));
  body.drag = from.number("drag", body.drag, kNotNegative);
  body.gravity_scale = from.number("gravity_scale", 1, kAnyNumber);
  body.solver = read_solver(reading, from, reading.solver);
  const bool has_shapes = from.has("shape") || from.has("shapes");
  body.collision = read_collision(reading, from, has_shapes, reading.collision);
  return body;
}

std::optional<RatioRecipe> read_ratio(const Reading& reading, NodeId node) {
  constexpr std::string_view kMoves[] = {"angle", "travel"};
  constexpr std::string_view kOffsets[] = {"offset", "offset_deg"};
  const Reader from = reading.open(node, "gear");
  RatioRecipe r;
  r.at = node;
  r.name = optional_name(from);
  const auto first = read_reference(from, "first", "the name of a joint", true);
  const auto second = read_reference(from, "second", "the name of a joint", true);
  if (from.has("first_coordinate")) r.slides_first = from.word("first_coordinate", 0, kMoves) == 1;
  if (from.has("second_coordinate")) r.slides_second = from.word("second_coordinate", 0, kMoves) == 1;
  const NodeId ratio = from.need("ratio", "how far the second moves for each unit of the first");
  r.ratio = from.number("ratio", 1, kAnyNumber);
  if (ratio != kNoNode && r.ratio == 0)
    from.complaints.refuse_value(ratio, "a number other than 0");
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

std::optional<StringRecipe> read_string(const Reading& reading, NodeId node) {
  constexpr std::string_view kLengths[] = {"length", "slack"};
  const Reader from = reading.open(node, "cable");
  StringRecipe string;
  string.at = node;
  string.name = optional_name(from);
  const auto a = read_reference(from, "a", kBodyOrWorld, true);
  const auto b = read_reference(from, "b", kBodyOrWorld, true);
  string.at_a = read_point(from, "point_a", "anchor_a");
  string.at_b = read_point(from, "point_b", "anchor_b");
  from.one_of(kLengths);
  if (from.has("length")) string.length = from.number("length", 1, kSize);
  string.slack = from.number("slack", 1, kPositive);
  string.compliance = from.number("compliance", 0, kNotNegative);
  if (!a || !b) return std::nullopt;
  string.a = *a, string.b = *b;
  return string;
}

std::optional<PinRecipe> read_pin(const Reading& reading, NodeId node) {
  const Reader from = reading.open(node, "pin");
  PinRecipe pin;
  pin.at = node;
  pin.name = optional_name(from);
  const auto body = read_reference(from, "body", "the name of a body", true);
  pin.point = read_point(from, "point", "anchor");
  constexpr std::string_view kGoals[] = {"target", "anchor_to"};
  from.one_of(kGoals);
  pin.target = from.vec_if("target");
  pin.anchor_to = from.vec_if("anchor_to");
  pin.to = read_reference(from, "to", "the name of a body", false);
  if (pin.anchor_to && !from.has("to"))
    reading.complaints.refuse_key(
        from.find("anchor_to"),
        "found \"anchor_to\" without \"to\", expected the body it lies in");
  pin.pin.priority = from.whole("priority", 0, -1'000'000, 1'000'000);
  pin.pin.grip = static_cast<Grip>(from.word("grip", 0, kGrips));
  pin.pin.stiffness = from.number("stiffness", pin.pin.stiffness, kPositive);
  if (!body) return std::nullopt;
  pin.body = *body;
  return pin;
}

std::optional<DriveRecipe> read_drive(const Reading& reading, NodeId node) {
  constexpr std::string_view kPaths[] = {"keyframes", "lissajous"};
  const Reader from = reading.open(node, "path");
  DriveRecipe drive;
  drive.at = node;
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
  instance.at = node;
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
  grid.each.at = node;
  grid.each.name = from.name();
  const auto prefab = read_reference(from, "prefab", "the name of a prefab", true);
  grid.each.pose = from.pose();
  grid.each.time_offset = from.number("time_offset", 0, kTime);
  grid.each.solver = read_solver(reading, from, reading.solver);
  grid.spacing = from.vec("spacing", grid.spacing);
  const NodeId count = from.need("count", "how many copies along x, y and z");
  Real n[3] = {0, 0, 0};
  constexpr Range kCopies{1, 1e6, "a whole number from 1 to 1000000"};
  if (count != kNoNode && read_numbers(reading.json, reading.complaints, count, n, kCopies)) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (n[i] != std::floor(n[i])) reading.complaints.refuse_value(count, "whole numbers");
      grid.count[i] = static_cast<int>(n[i]);
    }
  }
  if (prefab) grid.each.prefab = *prefab;
  return grid;
}

}  // namespace pantin
