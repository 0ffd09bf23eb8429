#include "engine/world/closing.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/disjoint_sets.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::detail {
namespace {

enum More : int { kBall, kHinge, kKind, kActs };

/// Axes count as parallel if 1 - cosine of their angle is below this.
constexpr Real kParallel = 1e-9;

bool is_dynamic(const World& world, Entity e) {
  const Body* body = world.bodies.find(e);
  return body && body->motion == Motion::dynamic;
}

/// Which joints connect a set of bodies: all fixed, or all hinges with parallel axes.
struct Family {
  bool all_fixed = true, all_parallel = true;
  Vec3 axis{0};
};

void add(const World& world, const Link& link, Family& family) {
  switch (info_of(link.joint.kind).rotations) {
    case Turns::nowhere:
      return;
    case Turns::about_x:
      break;
    case Turns::freely:
    case Turns::about_two:
    case Turns::own:
      family.all_fixed = family.all_parallel = false;
      return;
  }
  family.all_fixed = false;
  const Body* a = world.bodies.find(link.a);
  const Vec3 axis = a ? a->pose.rotation * (link.joint.frames.a() * Vec3(1, 0, 0)) : Vec3(0);
  if (family.axis == Vec3(0)) family.axis = axis;
  family.all_parallel =
      family.all_parallel && std::abs(glm::dot(axis, family.axis)) > 1 - kParallel;
}

}  // namespace

int more_than_a_point(const World& world, std::uint32_t link) {
  const Joint& joint = world.links.values()[link].joint;
  const bool acts = joint.parameters.any() && joint.parameters->rotation.any();
  if (acts || joint.limits.any() || world.joint_drives.find(world.links.owners()[link]))
    return kActs;
  const Turns turns = info_of(joint.kind).rotations;
  return turns == Turns::freely ? kBall : turns == Turns::about_x ? kHinge : kKind;
}

std::vector<std::uint32_t> growing_order(const World& world, std::span<const std::uint32_t> links) {
  std::vector<std::uint32_t> order(links.begin(), links.end());
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return more_than_a_point(world, i) > more_than_a_point(world, j);
  });
  return order;
}

std::vector<std::uint32_t> list_closing(const World& world, std::span<const std::uint32_t> links) {
  if (links.empty()) return {};
  DisjointSets forest(world.bodies.size());
  std::vector<std::uint32_t> closing, holds;
  for (const std::uint32_t i : growing_order(world, links)) {
    const Link& link = world.links.values()[i];
    const bool a = is_dynamic(world, link.a), b = is_dynamic(world, link.b);
    if (a != b) holds.push_back(i);
    if (!a || !b) continue;
    const std::uint32_t one = world.bodies.slot(link.a), two = world.bodies.slot(link.b);
    if (forest.root(one) == forest.root(two))
      closing.push_back(i);
    else
      forest.join(one, two);
  }
  if (closing.empty() && holds.size() < 2) return {};
  const auto body_of = [&](std::uint32_t i) {
    const Link& link = world.links.values()[i];
    return world.bodies.slot(is_dynamic(world, link.a) ? link.a : link.b);
  };
  std::vector<std::uint8_t> is_held(world.bodies.size(), 0);
  for (const std::uint32_t i : holds) {
    std::uint8_t& held = is_held[forest.root(body_of(i))];
    if (held) closing.push_back(i);
    held = 1;
  }
  std::vector<Family> families(closing.empty() ? 0 : world.bodies.size());
  if (!families.empty())
    for (const std::uint32_t i : links)
      if (const std::uint32_t body = body_of(i); body != kNoSlot)
        add(world, world.links.values()[i], families[forest.root(body)]);
  std::erase_if(closing, [&](std::uint32_t i) {
    const Family& family = families[forest.root(body_of(i))];
    const int more = more_than_a_point(world, i);
    return more == kBall || family.all_fixed || (more == kHinge && family.all_parallel);
  });
  return closing;
}

}  // namespace pantin::detail
