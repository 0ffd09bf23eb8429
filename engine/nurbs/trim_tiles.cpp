#include "engine/nurbs/trim_tiles.hpp"

#include <algorithm>
#include <unordered_map>

#include "engine/nurbs/trim.hpp"

namespace pantin::detail::nurbs {
namespace {

constexpr int kDeepest = 8;    // halvings of a triangle's sides
constexpr Real kExact = 1e-3;  // chords: how far a corner of a tile is within the trim at most
constexpr Real kFine = 16;  // chords: triangles of this size are not cut for thin parts of a trim

using Triangle = std::array<std::uint32_t, 3>;

class Clipper {
 public:
  Clipper(const Skin& skin, int face, Real chord, Tessellation& tiles)
      : number_(face), face_(skin.face(face)), trim_(*face_.trim()), chord_(chord), tiles_(tiles) {}

  void cut(const Triangle& t, int depth) {
    Range u{1e300, -1e300}, v = u;
    for (const std::uint32_t k : t) {
      const Place& at = tiles_.places[k];
      u = {std::min(u.low, at.u), std::max(u.high, at.u)};
      v = {std::min(v.low, at.v), std::max(v.high, at.v)};
    }
    if (!trim_.may_cross(u, v)) {
      const Vec3 middle = (uv(t[0]) + uv(t[1]) + uv(t[2])) / 3.0;
      if (trim_.holds(middle.x, middle.y)) kept_.push_back(t);
      return;
    }
    if (depth < kDeepest && is_coarse(t)) {
      const std::uint32_t a = middle_of(t[0], t[1]), b = middle_of(t[1], t[2]),
                          c = middle_of(t[2], t[0]);
      for (const Triangle& part :
           {Triangle{t[0], a, c}, Triangle{a, t[1], b}, Triangle{c, b, t[2]}, Triangle{a, b, c}})
        cut(part, depth + 1);
      return;
    }
    clip(t);
  }
  std::vector<Triangle> kept() { return std::move(kept_); }

 private:
  Vec3 uv(std::uint32_t k) const { return {tiles_.places[k].u, tiles_.places[k].v, 0}; }
  bool is_in(std::uint32_t k) {
    if (is_in_.size() <= k) is_in_.resize(tiles_.places.size(), kUnknown);
    if (is_in_[k] == kUnknown)
      is_in_[k] = trim_.holds(tiles_.places[k].u, tiles_.places[k].v) ? 1 : 0;
    return is_in_[k] == 1;
  }
  std::uint32_t add(Vec3 at) {
    tiles_.points.push_back(face_.at(at.x, at.y).s);
    tiles_.normals.push_back(normal_at(face_, at.x, at.y));
    tiles_.places.push_back({number_, at.x, at.y});
    return static_cast<std::uint32_t>(tiles_.points.size() - 1);
  }
  /// The point of a side, which its two triangles share.
  template <class At>
  std::uint32_t shared(std::unordered_map<std::uint64_t, std::uint32_t>& points, std::uint32_t a,
                       std::uint32_t b, const At& at) {
    const std::uint64_t side = std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
    const auto [entry, is_new] = points.try_emplace(side, 0);
    if (is_new) entry->second = add(at());
    return entry->second;
  }
  std::uint32_t middle_of(std::uint32_t a, std::uint32_t b) {
    return shared(middles_, a, b, [&] { return (uv(a) + uv(b)) / 2.0; });
  }
  /// Where a side of which one end is kept leaves the trim.
  std::uint32_t exit_of(std::uint32_t a, std::uint32_t b) {
    return shared(exits_, a, b, [&] { return is_in(a) ? last_kept(a, b) : last_kept(b, a); });
  }
  Vec3 last_kept(std::uint32_t in, std::uint32_t out) const {
    Vec3 low = uv(in), high = uv(out);
    Real length = glm::distance(tiles_.points[in], tiles_.points[out]);
    for (; length > kExact * chord_; length /= 2) {
      const Vec3 middle = (low + high) / 2.0;
      (trim_.holds(middle.x, middle.y) ? low : high) = middle;
    }
    return low;
  }

  /// Whether the chord that would cut a triangle leaves the loop, or parts may be missed.
  bool is_coarse(const Triangle& t) {
    Real longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest =
          std::max(longest, glm::distance(tiles_.points[t[k]], tiles_.points[t[(k + 1) % 3]]));
    if (longest <= kFine * chord_) return false;
    Vec3 exits[2]{};
    int crossings = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (is_in(a) == is_in(b)) continue;
      exits[crossings++ % 2] = uv(exit_of(a, b));
    }
    if (crossings == 0) return true;
    const Vec3 middle = (exits[0] + exits[1]) / 2.0;
    const Vec3 beside = trim_.at(trim_.beside(middle.x, middle.y))[0];
    const auto on = [&](Vec3 at) {
      return face_.at(face_.u().domain().clamped(at.x), face_.v().domain().clamped(at.y)).s;
    };
    return glm::distance(on(middle), on(beside)) > chord_ / 2;
  }

  void clip(const Triangle& t) {
    std::vector<std::uint32_t> kept;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (is_in(a)) kept.push_back(a);
      if (is_in(a) != is_in(b)) kept.push_back(exit_of(a, b));
    }
    for (std::size_t k = 2; k < kept.size(); ++k) {
      const auto& p = tiles_.points;
      const Triangle part{kept[0], kept[k - 1], kept[k]};
      if (p[part[0]] != p[part[1]] && p[part[1]] != p[part[2]] && p[part[2]] != p[part[0]])
        kept_.push_back(part);
    }
  }

  static constexpr signed char kUnknown = -1;

  int number_;
  const Face& face_;
  const Trim& trim_;
  Real chord_;
  Tessellation& tiles_;
  std::vector<Triangle> kept_;
  std::vector<signed char> is_in_;  // by point
  std::unordered_map<std::uint64_t, std::uint32_t> middles_, exits_;
};

}  // namespace

void trim_tiles(const Skin& skin, TilesOfFace of, Real chord, Tessellation& tiles) {
  const auto begin = tiles.triangles.begin() + static_cast<std::ptrdiff_t>(of.first);
  const std::vector<Triangle> whole(begin, tiles.triangles.end());
  tiles.triangles.erase(begin, tiles.triangles.end());
  Clipper clipper(skin, of.face, chord, tiles);
  for (const Triangle& t : whole) clipper.cut(t, 0);
  for (const Triangle& t : clipper.kept()) tiles.triangles.push_back(t);
}

void drop_unused_points(Tessellation& tiles) {
  constexpr std::uint32_t kUnused = UINT32_MAX;
  std::vector<std::uint32_t> number(tiles.points.size(), kUnused);
  Tessellation used;
  for (auto& t : tiles.triangles)
    for (std::uint32_t& k : t) {
      if (number[k] == kUnused) {
        number[k] = static_cast<std::uint32_t>(used.points.size());
        used.points.push_back(tiles.points[k]), used.normals.push_back(tiles.normals[k]);
        used.places.push_back(tiles.places[k]);
      }
      k = number[k];
    }
  used.triangles = std::move(tiles.triangles);
  tiles = std::move(used);
}

}  // namespace pantin::detail::nurbs
