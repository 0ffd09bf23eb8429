// Contact points of curves in a step of RATTLE, and their active set.
#include <algorithm>
#include <cmath>

#include "engine/solvers/planar/rattle.hpp"

namespace pantin::detail::planar {

bool Rattle::is_active(std::size_t curve, std::size_t place) const {
  const FlatCurve& c = all_.curves[of_.curves[curve]];
  PANTIN_ASSERT(curve < of_.curves.size() && place < c.most_places());
  const CurvePlace& p = places_[curve][place];
  return p.used && !c.over && (!c.lifts || p.presses);
}

void Rattle::note_starts() {
  std::size_t at = 0;
  of_.starts.assign(kMostPlaces * of_.curves.size(), {});
  for (std::size_t i = 0; i < of_.curves.size(); ++i)
    for (std::size_t k = 0; k < all_.curves[of_.curves[i]].most_places(); ++k)
      of_.starts[kMostPlaces * i + k] = start_.nows[at++];
}

/// Searches the contact points of a unilateral curve again; false if there is none near.
bool Rattle::look_again(std::size_t curve) {
  const FlatCurve& c = all_.curves[of_.curves[curve]];
  FlatCurve looked = c;
  looked.places = places_[curve], looked.known = true;
  looked.searched.position = Vec3(1e300, 0, 0);
  search_places(looked, m_);
  places_[curve] = looked.places, searched_[curve] = looked.searched;
  bool any = false;
  for (CurvePlace& place : places_[curve]) {
    if (!place.used) continue;
    const PlaceNow now = follow(c, place, m_);
    if (now.status != nurbs::ContactStatus::found) {
      place.used = false;
      continue;
    }
    any = true, place.presses = place.presses || now.gap < 0;
  }
  return any;
}

/// Whether curves overlap at a contact point that was unknown when the step began, as when a box
/// tips over an edge.
bool Rattle::meets_anew() {
  bool any = false;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    const bool lies = std::any_of(places_[i].begin(), places_[i].end(),
                                  [](const CurvePlace& p) { return p.used && p.lies; });
    if (!c.lifts || c.over || !(lies || is_search_due(c, searched_[i], m_))) continue;
    const auto before = places_[i];
    if (!look_again(i)) {
      places_[i] = before;
      continue;
    }
    for (std::size_t k = 0; k < kMostPlaces; ++k)
      any = any || (places_[i][k].presses && follow(c, places_[i][k], m_).gap < -kAccepted * size_);
  }
  return any;
}

/// Restarts from the free motion with the active rows of now. A contact point that does not exist
/// at the start, as the far corner of a box that tips over, takes its row at the end.
void Rattle::restart() {
  collect(now_);
  place_at(from_), drive_others(end_ - h_);
  for (std::size_t i = 0; i < of_.bodies.size(); ++i)
    m_.velocity[of_.bodies[i]] = work_.from_velocity[i];
  work_.kept = places_;
  collect(start_);
  places_ = work_.kept;
  std::size_t row = start_.first_curve, at = 0;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    for (std::size_t k = 0; k < c.most_places(); ++k, ++at, row += c.rows_per_place())
      if (is_active(i, k) && start_.nows[at].status != nurbs::ContactStatus::found)
        for (std::size_t r = row; r < row + c.rows_per_place(); ++r) start_.rows[r] = now_.rows[r];
  }
  soften(start_.rows, gives_);
  lambda_.assign(start_.rows.size(), 0);
  drift();
}

/// Updates the active set after an iteration. Returns whether it changed; nothing on failure.
std::optional<bool> Rattle::switch_places(int& looks) {
  bool changed = false;
  std::size_t row = now_.first_curve, at = 0;
  for (std::size_t i = 0; i < of_.curves.size(); ++i) {
    const FlatCurve& c = all_.curves[of_.curves[i]];
    bool look = false;
    for (std::size_t k = 0; k < c.most_places(); ++k, ++at, row += c.rows_per_place()) {
      const PlaceNow& now = now_.nows[at];
      const bool active = is_active(i, k), found = now.status == nurbs::ContactStatus::found;
      if (active && !found && !c.lifts) return std::nullopt;
      if (!c.lifts) continue;
      CurvePlace& place = places_[i][k];
      if (active && !found) {
        place = {}, look = true;
        continue;
      }
      if (!found) continue;
      const bool pulls =
          active && lambda_[row] + h_ * first_[row] < 0 && std::abs(now.gap) < kAccepted * size_;
      const bool overlaps = !active && now.gap < -kClosed * size_ && looks >= 0;
      if (pulls) place.presses = false, changed = true;
      if (overlaps) place.presses = true, place.slip = 0, changed = true;
    }
    if (!look) continue;
    if (++looks > kMostLooks || !look_again(i)) return std::nullopt;
    changed = true;
  }
  return changed;
}

}  // namespace pantin::detail::planar
