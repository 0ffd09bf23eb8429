// Belts round pulleys.
#include <algorithm>
#include <pantin/joints.hpp>

#include "engine/pantin/detail/findings.hpp"
#include "engine/world/belt_sides.hpp"
#include "engine/world/design.hpp"
#include "engine/world/ties.hpp"

namespace pantin {

using namespace detail;

namespace {

void check_pulley(Findings& findings, const BeltJoint::Pulley& p) {
  const World& world = findings.world();
  findings.body("pulleys", p.body), findings.finite("pulleys", p.point);
  if (!findings.ok()) return;
  if (world.bodies[p.body].motion == Motion::fixed)
    findings.add("pulleys", "a fixed body", "one that rotates: the belt does not slip on it");
  if (p.outline.empty())
    findings.above_zero("radius", p.radius);
  else if (hull_outline(p.outline).corners.empty())
    findings.add("outline", "corners on one line", "three or more that are not");
}

BeltPulley placed(const World& world, const BeltJoint::Pulley& p) {
  const Pose& at = world.bodies[p.body].pose;
  BeltPulley made;
  made.body = p.body, made.anchor = to_local(at, p.point);
  made.frame = glm::conjugate(at.rotation);
  if (p.outline.empty())
    made.outline.radius = p.radius;
  else
    made.outline = hull_outline(p.outline);
  return made;
}

}  // namespace

Result<Entity> add_to(World& world, const BeltJoint& described) {
  Findings findings(world, "BeltJoint", described.name);
  const std::size_t count = described.pulleys.size();
  if (count < 2 || count > kMostPulleys)
    findings.add("pulleys", std::to_string(count) + " of them", "2 to 16");
  if (described.friction > 0 && count > 2)
    findings.add("friction", "more than two pulleys",
                 "two: with more the slipping pulley is undetermined");
  findings.not_negative("friction", described.friction);
  findings.not_negative("pretension", described.pretension);
  for (const BeltJoint::Pulley& p : described.pulleys) check_pulley(findings, p);
  if (!findings.ok()) return findings.take();
  Belt belt;
  belt.friction = described.friction, belt.pretension = described.pretension;
  BeltSides sides{{}, described.crossed};
  std::vector<Pose> poses;
  bool moves = false;
  for (const BeltJoint::Pulley& p : described.pulleys) {
    for (const BeltPulley& other : belt.pulleys)
      if (other.body == p.body) findings.add("pulleys", "two on one body", "one on each");
    belt.pulleys.push_back(placed(world, p));
    sides.is_outside.push_back(p.is_outside), poses.push_back(world.bodies[p.body].pose);
    moves = moves || world.bodies[p.body].motion == Motion::dynamic;
  }
  for (const BeltJoint::Pulley& p : described.pulleys)
    findings.known({{feature_of(belt)}}, {p.body});
  if (!moves) findings.add("pulleys", "none that is dynamic", "one that is");
  if (!findings.ok()) return findings.take();
  if (const std::string why = lay_round(belt, poses, sides); !why.empty()) {
    const std::size_t comma = why.find(", expected ");
    findings.add("pulleys", why.substr(0, comma), why.substr(comma + 11));
    return findings.take();
  }
  const Entity made = add_belt(world, belt, described.name);
  world.store<LaidBelt>().add(made, {poses});
  return made;
}

std::optional<BeltState> belt_state(const World& world, Entity belt) {
  const Belt* b = world.belts.find(belt);
  if (!b) return std::nullopt;
  BeltState state{b->length, b->defect, b->travel, b->slips, {}};
  for (const BeltPulley& p : b->pulleys) state.tensions.push_back(p.tension);
  return state;
}

}  // namespace pantin
