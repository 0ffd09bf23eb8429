// Starts for pairs of faces: cells that may hold what is looked for, by bounds that hold.
#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/nurbs/pair_descent.hpp"

namespace pantin::detail::nurbs {
namespace {

/// A cell of one skin, in the frame of b.
struct Cell3 {
  Vec3 centre{0}, normal{0};
  const Leaf* leaf = nullptr;
  int face = 0;
};

// How far apart two discs are at least: by their balls, and along both normals.
Real least_distance(const Cell3& a, const Cell3& b) {
  const Vec3 d = a.centre - b.centre;
  const Real between = glm::length(d) - a.leaf->radius - b.leaf->radius;
  const auto reach = [](const Cell3& cell, Vec3 axis) {
    const Real cosine = std::min(std::abs(glm::dot(cell.normal, axis)), 1.0);
    const Real sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
    return std::min(cell.leaf->radius,
                    cell.leaf->half_thickness * cosine + cell.leaf->radius * sine);
  };
  const auto along = [&](Vec3 axis) {
    return std::abs(glm::dot(d, axis)) - reach(a, axis) - reach(b, axis);
  };
  const Real least = std::max({between, along(a.normal), along(b.normal), 0.0});
  return least * (1 - 1e-12);
}

// Whether normals within the two cells may be opposite, with the line between the points along
// them.
bool may_face(const Cell3& a, const Cell3& b) {
  const Real turn = a.leaf->turn + b.leaf->turn;
  if (turn < kPi && glm::dot(a.normal, -b.normal) < std::cos(turn) - 1e-9) return false;
  if (b.leaf->turn > kPi / 2) return true;
  const Vec3 d = a.centre - b.centre;
  const Real reach = a.leaf->radius + b.leaf->radius, along = glm::dot(d, b.normal);
  const Real beside = std::sqrt(std::max(glm::dot(d, d) - along * along, 0.0));
  return beside <= reach + (glm::length(d) + reach) * std::sin(b.leaf->turn) + 1e-12;
}

/// Walks two trees together.
class PairWalk {
 public:
  explicit PairWalk(const Meeting& of)
      : a_(of.a),
        b_(of.b),
        turn_(glm::mat3_cast(of.a_in_b.rotation)),
        origin_(of.a_in_b.position) {}

  /// Calls `found(a, b)` for the cells whose distance may be below `limit()`.
  template <class Limit, class Found>
  void run(Limit&& limit, Found&& found) const {
    for (int i = 0; i < static_cast<int>(a_.faces().size()); ++i)
      for (int j = 0; j < static_cast<int>(b_.faces().size()); ++j)
        walk({i, 0, j, 0}, limit, found);
  }

 private:
  struct Nodes {
    int face_a;
    std::uint32_t a;
    int face_b;
    std::uint32_t b;
  };

  template <class Limit, class Found>
  void walk(const Nodes& at, Limit& limit, Found& found) const {
    const auto& nodes_a = a_.face(at.face_a).tree().nodes();
    const auto& nodes_b = b_.face(at.face_b).tree().nodes();
    const BallTree::Node &na = nodes_a[at.a], &nb = nodes_b[at.b];
    const auto least = [&](const BallTree::Node& x, const BallTree::Node& y) {
      return glm::distance(turn_ * x.ball.centre + origin_, y.ball.centre) - x.ball.radius -
             y.ball.radius;
    };
    if (least(na, nb) > limit()) return;
    if (na.is_leaf && nb.is_leaf) {
      const Leaf& la = a_.face(at.face_a).leaves()[na.first];
      const Leaf& lb = b_.face(at.face_b).leaves()[nb.first];
      found(Cell3{turn_ * la.centre + origin_, turn_ * la.normal, &la, at.face_a},
            Cell3{lb.centre, lb.normal, &lb, at.face_b});
      return;
    }
    const bool cuts_a = !na.is_leaf && (nb.is_leaf || na.ball.radius >= nb.ball.radius);
    const auto child = [&](std::uint32_t k) {
      Nodes next = at;
      (cuts_a ? next.a : next.b) = (cuts_a ? na : nb).first + k;
      return next;
    };
    const auto distance = [&](const Nodes& n) { return least(nodes_a[n.a], nodes_b[n.b]); };
    Nodes one = child(0), two = child(1);
    if (distance(one) > distance(two)) std::swap(one, two);
    walk(one, limit, found), walk(two, limit, found);
  }

  const Skin &a_, &b_;
  Mat3 turn_;
  Vec3 origin_;
};

PlacePair middles(const Cell3& a, const Cell3& b) {
  return {{a.face, a.leaf->u.middle(), a.leaf->v.middle()},
          {b.face, b.leaf->u.middle(), b.leaf->v.middle()}};
}

constexpr Real kStraight = 0.2;  // rad: one start finds what there is in a cell that turns no more

/// Places to start from within a cell: its middle, or those of its quarters.
struct Starts {
  std::array<Place, 4> at;
  std::size_t count;
};
Starts starts_in(const Cell3& cell) {
  const Range &u = cell.leaf->u, &v = cell.leaf->v;
  if (cell.leaf->turn <= kStraight) return {{Place{cell.face, u.middle(), v.middle()}}, 1};
  Starts all{{}, 4};
  for (std::size_t i = 0; i < 4; ++i)
    all.at[i] = {cell.face, u.low + u.width() * (i % 2 == 0 ? 0.25 : 0.75),
                 v.low + v.width() * (i < 2 ? 0.25 : 0.75)};
  return all;
}

/// Contacts by gap, each once.
class Collected {
 public:
  Collected(std::span<CommonNormal> out, Real alike) : out_(out), alike_(alike) {}
  std::size_t count() const { return count_; }

  void add(const CommonNormal& found) {
    const auto begin = out_.begin(), end = begin + static_cast<std::ptrdiff_t>(count_);
    const auto is_same = [&](const CommonNormal& o) {
      return glm::distance(o.on_a, found.on_a) < alike_ &&
             glm::distance(o.on_b, found.on_b) < alike_;
    };
    if (std::any_of(begin, end, is_same)) return;
    const auto place = std::find_if(begin, end, [&](const auto& o) { return found.gap < o.gap; });
    if (place == out_.end()) return;
    // The last falls out where there is no room.
    count_ = std::min(count_ + 1, out_.size());
    const auto last = begin + static_cast<std::ptrdiff_t>(count_);
    std::move_backward(place, last - 1, last);
    *place = found;
  }

 private:
  std::span<CommonNormal> out_;
  Real alike_;
  std::size_t count_ = 0;
};

}  // namespace

ClosestPair closest_pair(const Meeting& of) {
  ClosestPair best;
  best.distance = 1e300;
  /// Where a descent ended; starts around there would end there again.
  struct Basin {
    Vec3 on_a, on_b;
  };
  std::vector<Basin> basins;
  const auto limit = [&] { return best.distance; };
  PairWalk(of).run(limit, [&](const Cell3& x, const Cell3& y) {
    if (least_distance(x, y) >= best.distance) return;
    const auto is_known = [&](const Basin& basin) {
      return glm::distance(basin.on_a, x.centre) < 2 * x.leaf->radius &&
             glm::distance(basin.on_b, y.centre) < 2 * y.leaf->radius;
    };
    if (std::any_of(basins.begin(), basins.end(), is_known)) return;
    const PairDescent end = descend(of, middles(x, y));
    ++best.descents;
    basins.push_back({end.on_a, end.on_b});
    if (!(end.distance < best.distance)) return;
    best.at = end.at, best.on_a = end.on_a, best.on_b = end.on_b, best.distance = end.distance;
    best.is_on_edge = end.is_on_edge;
  });
  return best;
}

std::size_t find_contacts(const Meeting& of, Real reach, std::span<CommonNormal> out) {
  Collected all(out, 1e-7 * std::min(of.a.size(), of.b.size()));
  const auto limit = [&] { return reach; };
  PairWalk(of).run(limit, [&](const Cell3& x, const Cell3& y) {
    if (least_distance(x, y) > reach || !may_face(x, y)) return;
    const Starts on_a = starts_in(x), on_b = starts_in(y);
    for (std::size_t i = 0; i < on_a.count; ++i)
      for (std::size_t j = 0; j < on_b.count; ++j) {
        const CommonNormal found = track_newton(of, {on_a.at[i], on_b.at[j]});
        const bool is_contact = found.status == ContactStatus::found &&
                                std::abs(found.gap) <= reach && found.least_curvature > 0;
        if (is_contact) all.add(found);
      }
  });
  return all.count();
}

}  // namespace pantin::detail::nurbs
