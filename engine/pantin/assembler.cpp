#include <cmath>
#include <pantin/assembler.hpp>

#include "engine/assembly/assemble.hpp"
#include "engine/assembly/live.hpp"
#include "engine/base/rotation.hpp"

namespace pantin {

using namespace detail;
using namespace detail::assembly;

struct Assembler::Inside {
  Live live;
};

namespace {

bool is_all_finite(Vec3 v) { return std::isfinite(v.x + v.y + v.z); }

/// "found ..., expected ..." if a body cannot have a target, or a weight is invalid.
std::string fault_of(const World& world, Entity body, Real weight) {
  const Body* found = world.bodies.find(body);
  if (!found) return "body: found none, expected a body of the World";
  if (found->motion != Motion::dynamic)
    return "body: found " + world.name_of(body) + ", which cannot move, expected a dynamic body";
  if (!(weight > 0) || !std::isfinite(weight))
    return "weight: found a number that is not above 0, expected a positive one";
  return {};
}

/// The frame that a body was placed by, in its mass-centre frame.
Pose origin_of(const World& world, Entity body) {
  const Pose* origin = world.origins.find(body);
  return origin ? *origin : Pose{};
}

Quat along(Vec3 direction) {
  const Vec3 x = glm::normalize(direction), turn = glm::cross(Vec3(1, 0, 0), x);
  const Real sine = glm::length(turn);
  if (sine < 1e-12) return x.x > 0 ? kIdentity : from_rotation_vector({0, 0, kPi});
  return from_rotation_vector(std::atan2(sine, x.x) / sine * turn);
}

Target number(std::size_t i) { return {static_cast<std::uint32_t>(i)}; }

}  // namespace

Assembly assemble(World& world, const std::vector<Entity>& held, Real tolerance,
                  const std::vector<FreeLength>& free) {
  AssemblyChoices choices;
  choices.held = held, choices.effort.tolerance = tolerance;
  for (const FreeLength& f : free)
    choices.free.push_back({f.law, Quantity::length, 0, f.least, f.most});
  const AssemblyReport r = detail::assembly::assemble(world, choices);
  Assembly result{
      r.assembled,     r.residual, r.iterations, r.starts, static_cast<int>(r.mobility), {},
      r.contradictory, {}};
  for (const RedundantLaw& l : r.redundant) result.redundant.push_back(l.law);
  for (const DesignVariable& v : choices.free)
    result.lengths.push_back(detail::fault_of(world, v).empty() ? value_of(world, v).numbers.x : 0);
  return result;
}

Assembler::Assembler(const World& world) : inside_(std::make_unique<Inside>(Inside{{world, {}}})) {}
Assembler::~Assembler() = default;
Assembler::Assembler(const Assembler& from) : inside_(std::make_unique<Inside>(*from.inside_)) {}
Assembler& Assembler::operator=(const Assembler& from) { return *this = Assembler(from); }
Assembler::Assembler(Assembler&&) noexcept = default;
Assembler& Assembler::operator=(Assembler&&) noexcept = default;

Result<Target> Assembler::add(const PointTarget& t) {
  const World& world = inside_->live.world();
  if (const std::string fault = fault_of(world, t.body, t.weight); !fault.empty())
    return Error{"PointTarget: " + fault};
  if (!is_all_finite(t.point) || !is_all_finite(t.target))
    return Error{"PointTarget: found a point that is not finite, expected finite numbers"};
  const Vec3 own = to_world(origin_of(world, t.body), t.point);
  return number(inside_->live.add(
      {Goal::point, t.body, {own, kIdentity}, {t.target, kIdentity}, t.weight, t.weight}));
}

Result<Target> Assembler::add(const PoseTarget& t) {
  const World& world = inside_->live.world();
  std::string fault = fault_of(world, t.body, t.weight);
  if (fault.empty() && !(t.turn_weight >= 0))
    fault = "turn_weight: found a number below 0, expected 0 or more";
  if (fault.empty() &&
      (!is_all_finite(t.target.position) || !(std::abs(glm::length(t.target.rotation) - 1) < 1e-6)))
    fault = "target: found no pose, expected finite numbers and a unit quaternion";
  if (!fault.empty()) return Error{"PoseTarget: " + fault};
  return number(inside_->live.add({Goal::pose,
                                   t.body,
                                   origin_of(world, t.body),
                                   {t.target.position, glm::normalize(t.target.rotation)},
                                   t.weight,
                                   t.turn_weight}));
}

Result<Target> Assembler::add(const AimTarget& t) {
  const World& world = inside_->live.world();
  std::string fault = fault_of(world, t.body, t.weight);
  if (fault.empty() && !(glm::length(t.direction) > 0 && is_all_finite(t.direction)))
    fault = "direction: found no direction, expected a vector that is not zero";
  if (fault.empty() && (!is_all_finite(t.point) || !is_all_finite(t.target)))
    fault = "found a point that is not finite, expected finite numbers";
  if (!fault.empty()) return Error{"AimTarget: " + fault};
  const Pose origin = origin_of(world, t.body);
  const Pose own = compose(origin, Pose{t.point, along(t.direction)});
  return number(
      inside_->live.add({Goal::aim, t.body, own, {t.target, kIdentity}, t.weight, t.weight}));
}

bool Assembler::move(Target target, Vec3 to) {
  Live& live = inside_->live;
  if (!live.has(target.number) || !is_all_finite(to)) return false;
  live.move(target.number, {to, live.target(target.number).target.rotation});
  return true;
}

bool Assembler::move(Target target, const Pose& to) {
  Live& live = inside_->live;
  if (!live.has(target.number) || !is_all_finite(to.position) ||
      !(std::abs(glm::length(to.rotation) - 1) < 1e-6))
    return false;
  live.move(target.number, {to.position, glm::normalize(to.rotation)});
  return true;
}

bool Assembler::set_weight(Target target, Real weight) {
  Live& live = inside_->live;
  if (!live.has(target.number) || !(weight > 0) || !std::isfinite(weight)) return false;
  live.set_weight(target.number, weight, weight);
  return true;
}

void Assembler::remove(Target target) { inside_->live.remove(target.number); }
void Assembler::hold(Entity body) { inside_->live.hold(body); }
void Assembler::let_go(Entity body) { inside_->live.let_go(body); }

AssemblerErrors Assembler::iterate() {
  const LiveReport r = inside_->live.iterate();
  return {r.joint_error, r.target_error};
}

AssemblerErrors Assembler::settle(int iterations) {
  AssemblerErrors errors;
  for (int i = 0; i < iterations; ++i) {
    errors = iterate();
    if (inside_->live.last_step() < 1e-12) break;
  }
  return errors;
}

const World& Assembler::world() { return inside_->live.world(); }
void Assembler::write_to(World& world) const { inside_->live.write_to(world); }

}  // namespace pantin
