#pragma once
/// Nearest points by dense samples, each improved by a descent of its own, to compare with.
#include <catch2/catch.hpp>

#include "engine/nurbs/closest.hpp"
#include "tests/nurbs/samples.hpp"

namespace pantin::test {

using namespace pantin::detail::nurbs;

/// A surface by its points on a grid, so many to each span, for queries that look at all of them.
class Dense {
 public:
  Dense(const Face& face, int each)
      : face_(face), u_(samples_of(face.u(), each)), v_(samples_of(face.v(), each)) {
    for (Real u : u_)
      for (Real v : v_) points_.push_back(face.at(u, v).s);
  }

  /// From every grid point that is nearer than its neighbours, downhill.
  NearestPoint closest(Vec3 p) {
    squares_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Vec3 d = points_[i] - p;
      squares_[i] = glm::dot(d, d);
    }
    NearestPoint best{.distance = 1e300};
    for (std::size_t i = 0; i < u_.size(); ++i)
      for (std::size_t j = 0; j < v_.size(); ++j) {
        if (!is_least(i, j)) continue;
        const NearestPoint found = closest_from(face_, p, {u_[i], v_[j]});
        if (found.distance < best.distance) best = found;
      }
    return best;
  }

 private:
  static std::vector<Real> samples_of(const Knots& k, int each) {
    std::vector<Real> at;
    const std::vector<Real> breaks = k.breaks();
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
      for (int j = 0; j < each; ++j)
        at.push_back(breaks[i] + (breaks[i + 1] - breaks[i]) * j / each);
    at.push_back(breaks.back());
    return at;
  }
  Real square(std::size_t i, std::size_t j) const { return squares_[i * v_.size() + j]; }
  bool is_least(std::size_t i, std::size_t j) const {
    for (std::size_t k = std::max<std::size_t>(i, 1) - 1; k < std::min(i + 2, u_.size()); ++k)
      for (std::size_t l = std::max<std::size_t>(j, 1) - 1; l < std::min(j + 2, v_.size()); ++l)
        if (square(k, l) < square(i, j)) return false;
    return true;
  }

  const Face& face_;
  std::vector<Real> u_, v_;
  std::vector<Vec3> points_;
  std::vector<Real> squares_;
};

// Whether a parameter is at a knot where the surface may have a crease. A descent over the whole
// face does not end there, one within each piece does.
inline bool is_at_crease(const Knots& k, Real t) {
  const std::vector<Real> breaks = k.breaks();
  return std::any_of(breaks.begin() + 1, breaks.end() - 1, [&](Real knot) {
    return std::abs(knot - t) < 1e-9 && k.multiplicity(knot) >= k.degree;
  });
}

struct Tally {
  int queries = 0, uncertain = 0, at_creases = 0, brute_missed = 0, unexplained = 0;
  std::uint64_t looks = 0;
};

// Queries around one face. Where the two differ, the search has to be the nearer one.
inline void ask(const Face& face, int queries, Random& dice, Tally& tally) {
  Dense coarse(face, 10);
  const Ball ball = bounding_ball(face.surface().points);
  for (int i = 0; i < queries; ++i) {
    const Vec3 p = ball.centre + 1.5 * ball.radius * dice.in_cube(1);
    const NearestPoint found = closest_point(face, p), brute = coarse.closest(p);
    ++tally.queries, tally.looks += found.looks, tally.uncertain += found.is_certain ? 0 : 1;
    REQUIRE(glm::distance(found.point, p) == Approx(found.distance).epsilon(1e-12));
    REQUIRE(glm::distance(face.at(found.u, found.v).s, found.point) < 1e-14 * face.size());
    const Real off = found.distance - brute.distance, tolerance = 1e-11 * face.size();
    if (std::abs(off) <= tolerance) continue;
    const bool is_crease = is_at_crease(face.u(), found.u) || is_at_crease(face.v(), found.v);
    if (off < 0 && is_crease) {
      ++tally.at_creases;
      continue;
    }
    // What is nearer and on the face, as was checked above, is the better answer.
    if (off < 0) {
      ++tally.brute_missed;
      continue;
    }
    ++tally.unexplained;
    WARN("p " << p.x << ' ' << p.y << ' ' << p.z << ": off by " << off << " at " << found.u << ' '
              << found.v);
  }
}

inline Face random_face(int trial, Random& dice) {
  switch (trial % 5) {
    case 0:
      return Face(random_surface(3, 3, 6, 6, dice));
    case 1:
      return Face(bumpy_surface(3, 9, 0.3, dice));
    case 2:
      return Face(random_surface(2, 2, 5, 5, dice));
    case 3:
      return Face(random_surface(1 + trial % 4, 4, 6, 6, dice));
    default:
      return Face(bumpy_surface(2, 7, 0.5, dice));
  }
}

inline Tally ask_around(int faces, int queries, std::uint64_t seed) {
  Tally tally;
  Random dice(seed);
  for (int trial = 0; trial < faces; ++trial) ask(random_face(trial, dice), queries, dice, tally);
  return tally;
}

}  // namespace pantin::test
