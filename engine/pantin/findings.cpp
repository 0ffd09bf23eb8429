#include "engine/pantin/detail/findings.hpp"

#include <algorithm>
#include <cstdio>

#include "engine/solvers/solver.hpp"
#include "engine/world/solver_list.hpp"

namespace pantin::detail {
namespace {

/// The solver of the island that a joint between these bodies would form: that of its first body
/// with settings.
Solver solver_of(const World& world, std::initializer_list<Entity> bodies) {
  if (world.settings.empty()) return world.default_settings.solver;
  const auto is_one = [&](std::uint32_t slot) {
    return std::find(bodies.begin(), bodies.end(), world.bodies.owners()[slot]) != bodies.end();
  };
  std::uint32_t first = kNoSlot;
  for (const IslandPlan& island : find_islands(world))
    if (std::any_of(island.slots.begin(), island.slots.end(), is_one))
      for (const std::uint32_t slot : island.slots)
        if (world.settings.find(world.bodies.owners()[slot])) first = std::min(first, slot);
  if (first == kNoSlot) return world.default_settings.solver;
  return world.settings[world.bodies.owners()[first]].solver;
}

}  // namespace

std::string shown(Real number) {
  char text[40];
  std::snprintf(text, sizeof text, "%g", number);
  return text;
}

std::string shown(Vec3 v) { return "(" + shown(v.x) + ", " + shown(v.y) + ", " + shown(v.z) + ")"; }

Findings::Findings(const World& world, const char* type, const std::string& name)
    : world_(world), who_(type) {
  if (!name.empty()) who_ += " '" + name + "'";
}

void Findings::add(const char* member, const std::string& found, const std::string& expected) {
  errors_.push_back({who_ + ": " + member + ": found " + found + ", expected " + expected});
}

void Findings::above_zero(const char* member, Real number) {
  if (!(number > 0) || !std::isfinite(number)) add(member, shown(number), "a number above 0");
}

void Findings::not_negative(const char* member, Real number) {
  if (!(number >= 0) || !std::isfinite(number))
    add(member, shown(number), "0 or a number above it");
}

void Findings::within(const char* member, Real number, Real low, Real high) {
  if (!(number >= low && number <= high))
    add(member, shown(number), "a number from " + shown(low) + " to " + shown(high));
}

void Findings::finite(const char* member, Real number) {
  if (!std::isfinite(number)) add(member, shown(number), "a finite number");
}

void Findings::finite(const char* member, Vec3 v) {
  if (!is_finite(v)) add(member, shown(v), "finite numbers");
}

void Findings::finite(const char* member, const Pose& pose) {
  finite(member, pose.position);
  rotation(member, pose.rotation);
}

Vec3 Findings::direction(const char* member, Vec3 v) {
  // Scaled first, so that the squares neither overflow nor underflow.
  const Real size = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (is_finite(v) && size > 0) return glm::normalize(v / size);
  add(member, shown(v), "a direction that is not zero");
  return {1, 0, 0};
}

Quat Findings::rotation(const char* member, Quat q) {
  const Real length = glm::length(q);
  if (is_finite(q) && length > 1e-6 && std::isfinite(length)) {
    // A unit quaternion is returned bit for bit.
    return std::abs(length - 1) < 1e-15 ? q : glm::normalize(q);
  }
  add(member,
      "(w " + shown(q.w) + ", x " + shown(q.x) + ", y " + shown(q.y) + ", z " + shown(q.z) + ")",
      "a quaternion that is not zero");
  return kIdentity;
}

void Findings::body(const char* member, Entity e) {
  if (world_.is_alive(e) && world_.bodies.find(e)) return;
  if (!e)
    add(member, "no entity", "a body");
  else if (!world_.is_alive(e))
    add(member,
        "an entity that was destroyed or is of another World (#" + std::to_string(e.index) + ")",
        "a body");
  else
    add(member, "'" + world_.name_of(e) + "', which is no body", "a body");
}

void Findings::bodies(Entity a, Entity b) {
  body("a", a), body("b", b);
  if (!ok()) return;
  if (a == b)
    add("b", "the same body as a", "another one");
  else if (world_.bodies[a].motion != Motion::dynamic && world_.bodies[b].motion != Motion::dynamic)
    add("a and b", "two bodies that joints do not move", "at least one that is dynamic");
}

void Findings::known(std::span<const Feature> features, std::initializer_list<Entity> bodies) {
  if (!ok() || features.empty()) return;
  const Solver solver = solver_of(world_, bodies);
  for (const Feature feature : features)
    if (!knows(solver_for(solver, feature), feature))
      add("solver",
          std::string("\"") + name_of(solver) + "\", which does not support " + name_of(feature),
          solvers_that_know(feature));
}

}  // namespace pantin::detail
