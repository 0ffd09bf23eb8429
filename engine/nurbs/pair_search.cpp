// Starts for pairs of faces: pairs of cells that guaranteed bounds cannot exclude.
#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/nurbs/cells.hpp"
#include "engine/nurbs/pair_descent.hpp"

namespace pantin::detail::nurbs {
namespace {

// Fraction of the least distance: closer values count as equal.
constexpr Real kNearer = 1 - 1e-10;

/// Walks two trees together, then halves the cells of their leaves.
class PairWalk {
 public:
  explicit PairWalk(const Meeting& of)
      : a_(of.a), b_(of.b), a_in_b_{glm::mat3_cast(of.a_in_b.rotation), of.a_in_b.position} {}

  /// Calls `found(a, b)` for pairs of straight cells that `asked` accepts, and all of whose parents
  /// it accepts. `asked` gets regions, as (a, b, pose of a), and cells, as (a, b).
  template <class Asked, class Found>
  void run(Asked&& asked, Found&& found) const {
    for (int i = 0; i < static_cast<int>(a_.faces().size()); ++i)
      for (int j = 0; j < static_cast<int>(b_.faces().size()); ++j)
        walk({i, 0, j, 0}, asked, found);
  }

 private:
  struct Nodes {
    int face_a;
    std::uint32_t a;
    int face_b;
    std::uint32_t b;
  };
  PatchCell cell_on_a(const Nodes& at, std::uint32_t leaf) const {
    PatchCell c = cell_of(a_.face(at.face_a), a_.face(at.face_a).leaves()[leaf], a_in_b_);
    c.index = at.face_a;
    return c;
  }
  PatchCell cell_on_b(const Nodes& at, std::uint32_t leaf) const {
    PatchCell c = cell_of(b_.face(at.face_b), b_.face(at.face_b).leaves()[leaf], {});
    c.index = at.face_b;
    return c;
  }

  template <class Asked, class Found>
  void walk(const Nodes& at, Asked& asked, Found& found) const {
    const Face &fa = a_.face(at.face_a), &fb = b_.face(at.face_b);
    if (!asked(fa.regions()[at.a], fb.regions()[at.b], a_in_b_)) return;
    const BallTree::Node &na = fa.tree().nodes()[at.a], &nb = fb.tree().nodes()[at.b];
    if (na.is_leaf && nb.is_leaf) {
      meet(cell_on_a(at, na.first), cell_on_b(at, nb.first), asked, found);
      return;
    }
    const bool cuts_a = !na.is_leaf && (nb.is_leaf || na.ball.radius >= nb.ball.radius);
    const auto child = [&](std::uint32_t k) {
      Nodes next = at;
      (cuts_a ? next.a : next.b) = (cuts_a ? na : nb).first + k;
      return next;
    };
    const auto distance = [&](const Nodes& n) {
      return least_distance(fa.regions()[n.a], fb.regions()[n.b], a_in_b_);
    };
    Nodes one = child(0), two = child(1);
    if (distance(one) > distance(two)) std::swap(one, two);
    walk(one, asked, found), walk(two, asked, found);
  }

  template <class Asked, class Found>
  void meet(const PatchCell& x, const PatchCell& y, Asked& asked, Found& found) const {
    if (!asked(x, y)) return;
    bool cuts_x = x.is_bent(), cuts_y = y.is_bent();
    if (!cuts_x && !cuts_y) {
      cuts_x = x.hides_other_cell(y.width()), cuts_y = y.hides_other_cell(x.width());
      if (!cuts_x && !cuts_y) {
        found(x, y);
        return;
      }
      cuts_x = cuts_x && (!cuts_y || x.sag >= y.sag);
    } else {
      cuts_x = cuts_x && (!cuts_y || x.turn >= y.turn);
    }
    for (int k = 0; k < 2; ++k) {
      if (cuts_x)
        meet(half_of(x, k, a_in_b_), y, asked, found);
      else
        meet(x, half_of(y, k, {}), asked, found);
    }
  }

  const Skin &a_, &b_;
  Standing a_in_b_;
};

// The approximate nearest points of two cells' parallelograms.
PlacePair start_of(const PatchCell& a, const PatchCell& b) {
  const Vec3 ways[4] = {a.along_u, a.along_v, -b.along_u, -b.along_v};
  Real shares[4] = {};
  approach(a.centre - b.centre, ways, shares);
  const auto place = [](const PatchCell& cell, Real u, Real v) {
    return Place{cell.index, cell.u.middle() + u * cell.u.width() / 2,
                 cell.v.middle() + v * cell.v.width() / 2};
  };
  return {place(a, shares[0], shares[1]), place(b, shares[2], shares[3])};
}

/// Contacts sorted by gap, without duplicates.
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
    // The last is dropped if there is no room.
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
  Vec3 toward(0);
  SearchCost cost;
  const auto asked = [&](const auto& x, const auto& y, const auto&... of_branches) {
    ++cost.pairs;
    if constexpr (sizeof...(of_branches) > 0)
      return least_distance(x, y, of_branches...) < best.distance * kNearer;
    else
      return least_distance(x, y, toward) < best.distance * kNearer;
  };
  PairWalk(of).run(asked, [&](const PatchCell& x, const PatchCell& y) {
    const PairDescent end = descend(of, start_of(x, y));
    ++cost.starts;
    if (!(end.distance < best.distance)) return;
    best.at = end.at, best.on_a = end.on_a, best.on_b = end.on_b, best.distance = end.distance;
    best.is_on_edge = end.is_on_edge;
    toward = end.distance > 0 ? (end.on_a - end.on_b) / end.distance : Vec3(0);
  });
  best.cost = cost;
  return best;
}

std::size_t find_contacts(const Meeting& of, Real reach, std::span<CommonNormal> out,
                          SearchCost* cost) {
  Collected all(out, 1e-7 * std::min(of.a.size(), of.b.size()));
  SearchCost spent;
  const auto asked = [&](const auto& x, const auto& y, const auto&... of_branches) {
    ++spent.pairs;
    return may_face(x, y, of_branches..., reach);
  };
  PairWalk(of).run(asked, [&](const PatchCell& x, const PatchCell& y) {
    ++spent.starts;
    const CommonNormal found = track_newton(of, start_of(x, y));
    const bool is_contact = found.status == ContactStatus::found && std::abs(found.gap) <= reach &&
                            found.least_curvature > 0;
    if (is_contact) all.add(found);
  });
  if (cost != nullptr) *cost = spent;
  return all.count();
}

}  // namespace pantin::detail::nurbs
