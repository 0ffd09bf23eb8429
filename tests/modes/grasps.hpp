#pragma once
/// Laminas to try: random grasps, and those of tests/data/quasistatic.json.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/modes/prepare.hpp"
#include "tests/base/random.hpp"

namespace pantin::test {

using namespace detail::modes;

struct Grasp {
  std::vector<Contact> contacts;
  Vec3 load{0};

  Lamina lamina() const { return {contacts, load}; }
};

inline Prepared prepared(const Grasp& grasp) {
  Prepared p;
  prepare(grasp.lamina(), p);
  return p;
}

inline Real normal_number(Random& random) {
  const Real u = random.between(0, 1), v = random.between(0, 1);
  return std::sqrt(-2 * std::log(1 - u)) * std::cos(2 * kPi * v);
}

/// Corners of a convex polygon around the origin, counter-clockwise.
inline std::vector<Vec2> random_polygon(Random& random) {
  for (;;) {
    std::vector<Real> at(3 + random.below(std::size_t{6}));
    for (Real& a : at) a = random.between(0, 2 * kPi);
    std::sort(at.begin(), at.end());
    Real widest = at.front() + 2 * kPi - at.back();
    for (std::size_t i = 1; i < at.size(); ++i) widest = std::max(widest, at[i] - at[i - 1]);
    if (widest > kPi) continue;
    const Real height = random.between(0.4, 1);
    std::vector<Vec2> corners;
    for (const Real a : at) corners.push_back({std::cos(a), height * std::sin(a)});
    return corners;
  }
}

/// Fingers with random velocities on the edges of a random convex lamina; gravity, or any load.
inline Grasp random_grasp(Random& random, std::size_t n) {
  const std::vector<Vec2> corners = random_polygon(random);
  Grasp grasp;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t e = random.below(corners.size());
    const Vec2 a = corners[e], b = corners[(e + 1) % corners.size()];
    const Real part = random.between(0.02, 0.98), length = std::hypot(b.x - a.x, b.y - a.y);
    Contact c;
    c.point = {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
    c.normal = {-(b.y - a.y) / length, (b.x - a.x) / length};
    c.velocity.x = normal_number(random);
    c.velocity.y = normal_number(random);
    grasp.contacts.push_back(c);
  }
  if (random.below(2) == 0) {
    Vec2 centre;
    for (const Vec2 c : corners) centre.x += c.x, centre.y += c.y;
    grasp.load = {0, -1, -centre.x / static_cast<Real>(corners.size())};
  } else {
    grasp.load = random.in_cube(1);
  }
  return grasp;
}

/// Each from 0 to `most`.
inline std::vector<Real> random_friction(Random& random, std::size_t n, Real most) {
  std::vector<Real> mu(n);
  for (Real& m : mu) m = random.between(0, most);
  return mu;
}

nlohmann::json quasistatic_vectors();
inline Grasp read_grasp(const nlohmann::json& j) {
  Grasp grasp;
  const auto pair = [](const nlohmann::json& v) {
    return Vec2{v[0].get<Real>(), v[1].get<Real>()};
  };
  for (std::size_t i = 0; i < j["r"].size(); ++i)
    grasp.contacts.push_back({pair(j["r"][i]), pair(j["n"][i]), pair(j["u"][i])});
  grasp.load = {j["g"][0].get<Real>(), j["g"][1].get<Real>(), j["g"][2].get<Real>()};
  return grasp;
}

}  // namespace pantin::test
