#pragma once
/// Small Worlds that several tests step: a hung chain, and a puppet with everything the engine
/// knows.
#include <vector>

#include "engine/world/ties.hpp"
#include "engine/world/world.hpp"

namespace pantin::test {

using namespace detail;

inline constexpr Real kHalfLink = 0.1;  // m

inline Body rod(Vec3 position) {
  Body body;
  body.pose.position = position;
  body.mass = 0.5, body.drag = 0.3;
  body.inertia = {0.0002, 0.0017, 0.0017};
  return body;
}

/// A chain of `count` rods along +x, its first one linked to a fixed hook at the origin.
struct Chain {
  World world;
  Entity hook;
  std::vector<Entity> rods, links;
};

inline Chain hung_chain(int count) {
  Chain chain;
  Body hook;
  hook.motion = Motion::fixed;
  chain.hook = chain.world.add_body(hook, "hook");
  Entity above = chain.hook;
  Vec3 end(0);
  for (int i = 0; i < count; ++i) {
    const Entity below = chain.world.add_body(rod({kHalfLink * (2 * i + 1), 0, 0}));
    chain.links.push_back(add_link(chain.world, {above, below, {end, {-kHalfLink, 0, 0}}}));
    chain.rods.push_back(below);
    above = below, end = {kHalfLink, 0, 0};
  }
  return chain;
}

/// A trunk of two rods with two arms, hung by strings from a bar that sways; one hand is pulled by
/// an exact pin, the other by a spring; a free rod flies beside it.
struct Puppet {
  World world;
  Entity bar, trunk, left, right, link, string, pin, free;
};

inline Puppet swaying_puppet() {
  Puppet p;
  World& w = p.world;
  Body bar;
  bar.motion = Motion::kinematic;
  bar.pose.position = {0, 1, 0};
  p.bar = w.add_body(bar, "bar");
  Lissajous sway;
  sway.centre = bar.pose;
  sway.amplitude = {0.1, 0.05, 0};
  sway.frequency = {0.7, 1.1, 0};
  w.paths.add(p.bar, {sway});

  p.trunk = w.add_body(rod({0, 0, 0}), "trunk");
  p.left = w.add_body(rod({-2 * kHalfLink, 0, 0}), "left");
  p.right = w.add_body(rod({2 * kHalfLink, 0, 0}), "right");
  p.link = add_link(w, {p.trunk, p.left, {{-kHalfLink, 0, 0}, {kHalfLink, 0, 0}}});
  add_link(w, {p.trunk, p.right, {{kHalfLink, 0, 0}, {-kHalfLink, 0, 0}}});
  p.string = add_cable(w, {p.bar, p.left, {{-0.3, 0, 0}, {-kHalfLink, 0, 0}, 1.0, 0}});
  add_cable(w, {p.bar, p.right, {{0.3, 0, 0}, {kHalfLink, 0, 0}, 1.02, 1e-4}});
  add_cable(w, {p.bar, p.trunk, {Vec3(0), Vec3(0), 1.05, 0}});

  Pin pull;
  pull.body = p.left;
  pull.anchor = {-kHalfLink, 0, 0};
  pull.target = {-0.35, 0.1, 0.05};
  p.pin = w.add_pin(pull, "pull");
  pull.body = p.right;
  pull.anchor = {kHalfLink, 0, 0};
  pull.target = {0.5, 0.2, 0};
  pull.kind = PinKind::spring;
  w.add_pin(pull);

  Body loose = rod({2, 1, 0});
  loose.angular_velocity = {1, 4, 0.5};
  loose.inertia = {0.001, 0.002, 0.0025};
  p.free = w.add_body(loose, "free");
  return p;
}

}  // namespace pantin::test
