#include "tools/peers/bodies/judge.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "engine/geometry/collide.hpp"
#include "engine/joints/kinds.hpp"

namespace pantin::peers {
namespace {

using detail::Aabb;

constexpr double kAway = 100;    // m
constexpr double kTouch = 1e-6;  // m: bodies laid on one another do not start within each other

/// Overlaps of a World's bodies.
struct Overlaps {
  Real deepest = 0;    // m
  Real come_upon = 0;  // m, the deepest of pairs that have been apart before
};

/// Finds the deepest overlap of a World's shapes, step by step.
class Depths {
 public:
  explicit Depths(const World& world) : layers_(layers_of(world)), jointed_(jointed_pairs(world)) {
    for (std::uint32_t slot = 0; slot < world.bodies.size(); ++slot) {
      const Shapes* shapes = world.shapes.find(world.bodies.owners()[slot]);
      if (!shapes || layers_.of[slot] < 0) continue;
      const bool moves = world.bodies.values()[slot].motion == Motion::dynamic;
      for (const Shape& shape : shapes->list) {
        if (moves && !detail::is_convex(shape.kind)) continue;
        (detail::is_unbounded(shape.kind) ? unbounded_ : bounded_)
            .push_back({&shape, slot, moves, {}});
      }
    }
    boxes_.resize(bounded_.size());
  }

  Overlaps look(const World& world) {
    const auto bodies = world.bodies.values();
    for (Placed& p : unbounded_) p.pose = compose(bodies[p.slot].pose, p.shape->local);
    for (std::size_t i = 0; i < bounded_.size(); ++i) {
      Placed& p = bounded_[i];
      p.pose = compose(bodies[p.slot].pose, p.shape->local);
      // What is nowhere is told as lost.
      boxes_[i] = is_finite(p.pose) ? detail::bounds_of(*p.shape, p.pose) : Aabb{Vec3(0), Vec3(0)};
    }
    tree_.build(boxes_);
    Overlaps found;
    overlapping_.clear();
    for (std::uint32_t i = 0; i < bounded_.size(); ++i) {
      const Placed& a = bounded_[i];
      if (!a.moves || !is_finite(a.pose)) continue;
      for (const Placed& b : unbounded_) add(a, b, found);
      tree_.query(boxes_[i], [&](std::uint32_t k) {
        if (k < i || !bounded_[k].moves) add(a, bounded_[k], found);
      });
    }
    std::sort(overlapping_.begin(), overlapping_.end());
    if (!has_begun_)
      from_the_start_ = overlapping_, has_begun_ = true;
    else
      std::erase_if(from_the_start_, [&](const Pair& p) {
        return !std::binary_search(overlapping_.begin(), overlapping_.end(), p);
      });
    return found;
  }

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;  // slots, lower first
  struct Placed {
    const Shape* shape = nullptr;
    std::uint32_t slot = 0;
    bool moves = false;
    Pose pose;
  };

  void add(const Placed& a, const Placed& b, Overlaps& found) {
    const Pair pair{std::min(a.slot, b.slot), std::max(a.slot, b.slot)};
    if (a.slot == b.slot || !is_finite(b.pose) || !layers_.may_touch(a.slot, b.slot) ||
        std::binary_search(jointed_.begin(), jointed_.end(), pair))
      return;
    points_.clear();
    detail::collide({*a.shape, a.pose}, {*b.shape, b.pose}, scratch_, {0, points_});
    Real depth = 0;
    for (const detail::ContactPoint& p : points_) depth = std::max(depth, -p.gap);
    if (depth > kTouch) overlapping_.push_back(pair);
    found.deepest = std::max(found.deepest, depth);
    if (!std::binary_search(from_the_start_.begin(), from_the_start_.end(), pair))
      found.come_upon = std::max(found.come_upon, depth);
  }

  Layers layers_;
  std::vector<Pair> jointed_, overlapping_;
  std::vector<Pair> from_the_start_;  // those that overlap since the start
  bool has_begun_ = false;
  std::vector<Placed> bounded_, unbounded_;
  std::vector<Aabb> boxes_;
  detail::AabbTree tree_;
  detail::NarrowPhaseScratch scratch_;
  std::vector<detail::ContactPoint> points_;
};

void place(World& world, const Frame& frame) {
  for (std::size_t i = 0; i < frame.bodies.size(); ++i) {
    const Moving& m = frame.bodies[i];
    Body& b = world.bodies.values()[i];
    b.pose.position = {m.position[0], m.position[1], m.position[2]};
    // Single precision leaves quaternions a little off unit length.
    b.pose.rotation =
        glm::normalize(Quat(m.rotation[3], m.rotation[0], m.rotation[1], m.rotation[2]));
    b.velocity = {m.velocity[0], m.velocity[1], m.velocity[2]};
    b.angular_velocity = {m.angular_velocity[0], m.angular_velocity[1], m.angular_velocity[2]};
  }
}

/// `a` beyond `b`, where what is not finite is beyond everything.
Real worse(Real a, Real b) { return std::isfinite(b) ? std::max(a, b) : INFINITY; }

Real worst_opening(const World& world) {
  const auto pose_of = [&](Entity e) {
    const Body* b = world.bodies.find(e);
    return b ? b->pose : Pose{};
  };
  Real worst = 0;
  for (const detail::Link& link : world.links.values()) {
    const detail::JointKindInfo& info = info_of(link.joint.kind);
    worst = worse(worst, info.holds_point
                             ? glm::length(residual(link.joint, pose_of(link.a), pose_of(link.b)))
                             : info.gap(link.joint, pose_of(link.a), pose_of(link.b)));
  }
  for (const Pin& pin : world.pins.values())
    if (pin.kind == PinKind::exact)
      worst = worse(worst, glm::length(to_world(pose_of(pin.body), pin.anchor) -
                                       to_world(pose_of(pin.to), pin.target)));
  return worst;
}

/// How far a joint has turned beyond its kind and its limits, rad.
Real worst_turn(const World& world) {
  Real worst = 0;
  for (const detail::Link& link : world.links.values()) {
    const Body *a = world.bodies.find(link.a), *b = world.bodies.find(link.b);
    const Quat rotation = relative_rotation(link.joint, a ? a->pose.rotation : kIdentity,
                                            b ? b->pose.rotation : kIdentity);
    worst = worse(worst, is_finite(rotation) ? violation(link.joint, rotation) : INFINITY);
  }
  return worst;
}

Real worst_stretch(const World& world) {
  Real worst = 0;
  for (const detail::Cable& cable : world.cables.values())
    if (const Body* a = world.bodies.find(cable.a), *b = world.bodies.find(cable.b); a && b)
      worst = worse(worst, detail::stretch(cable.joint, a->pose, b->pose));
  return worst;
}

struct Energy {
  Real kinetic = 0, potential = 0;
};
Energy energy_of(const World& world) {
  Energy e;
  for (const Body& b : world.bodies.values()) {
    if (b.motion != Motion::dynamic) continue;
    const Vec3 w = glm::conjugate(b.pose.rotation) * b.angular_velocity;
    e.kinetic += (b.mass * glm::dot(b.velocity, b.velocity) + glm::dot(w, b.inertia * w)) / 2;
    e.potential -= b.mass * b.gravity_scale * glm::dot(world.gravity, b.pose.position);
  }
  return e;
}

/// Half of what a body measures about its mass centre, m; at least what engines let bodies sink in.
Real size_of(const World& world, Entity body) {
  Real size = 0.1;
  if (const Shapes* shapes = world.shapes.find(body))
    for (const Shape& s : shapes->list)
      size = std::max(size, detail::reach_of(s) + glm::length(s.local.position));
  return size;
}

/// Which bodies are gone.
std::vector<bool> lost_bodies(const World& start, const World& now) {
  std::vector<bool> lost(now.bodies.size());
  for (std::size_t i = 0; i < lost.size(); ++i) {
    const Body& b = now.bodies.values()[i];
    if (b.motion != Motion::dynamic) continue;
    const Vec3 at = b.pose.position;
    const Real size = size_of(start, start.bodies.owners()[i]);
    lost[i] =
        !is_finite(b.pose) || !(glm::length(at - start.bodies.values()[i].pose.position) < kAway);
    for (std::size_t k = 0; k < lost.size() && !lost[i]; ++k) {
      const Shapes* shapes = start.shapes.find(start.bodies.owners()[k]);
      if (!shapes || start.bodies.values()[k].motion != Motion::fixed) continue;
      for (const Shape& shape : shapes->list)
        if (shape.kind == ShapeKind::plane)
          lost[i] = lost[i] ||
                    to_local(compose(start.bodies.values()[k].pose, shape.local), at).y < -size;
    }
  }
  return lost;
}

void judge_times(std::vector<double> ms, Verdict& verdict) {
  if (ms.empty()) return;
  for (const double x : ms) verdict.mean_ms += x / double(ms.size());
  std::sort(ms.begin(), ms.end());
  verdict.median_ms = ms[ms.size() / 2];
  verdict.p99_ms = ms[std::min(ms.size() - 1, ms.size() * 99 / 100)];
  verdict.most_ms = ms.back();
}

/// The farthest that any body was from where it is last.
double strayed(const std::deque<std::vector<Vec3>>& places) {
  double most = 0;
  for (const std::vector<Vec3>& then : places)
    for (std::size_t i = 0; i < then.size(); ++i)
      most = worse(most, glm::length(then[i] - places.back()[i]));
  return most;
}

}  // namespace

bool judge(const World& start, const std::string& file, Verdict& verdict) {
  MotionReader reader;
  if (!reader.open(file) || reader.bodies() != start.bodies.size()) return false;
  verdict.told = reader.told;
  for (const Body& b : start.bodies.values()) verdict.bodies += b.motion == Motion::dynamic;

  World now = start;
  Depths depths(start);
  verdict.depth_at_start = depths.look(start).deepest;
  const Energy before = energy_of(start);
  std::vector<double> ms;
  std::deque<std::vector<Vec3>> places;  // over the last second
  struct Trouble {
    Real opening, turn, depth;
  };
  std::deque<Trouble> troubles;  // over kRest
  int awake_until = 0;
  for (Frame frame; reader.next(frame);) {
    place(now, frame);
    ms.push_back(frame.ms);
    if (++verdict.frames; frame.awake > 0) awake_until = verdict.frames;
    const Real opening = worst_opening(now), turn = worst_turn(now);
    const Overlaps overlaps = depths.look(now);
    verdict.opening = worse(verdict.opening, opening), verdict.turn = worse(verdict.turn, turn);
    verdict.depth = worse(verdict.depth, overlaps.come_upon);
    verdict.stretch = worse(verdict.stretch, worst_stretch(now));
    troubles.push_back({opening, turn, overlaps.deepest});
    if (double(troubles.size()) > kRest * kFramesPerSecond) troubles.pop_front();
    const Energy e = energy_of(now);
    verdict.kinetic = e.kinetic;
    verdict.energy = e.kinetic + e.potential - before.kinetic - before.potential;
    verdict.gained = worse(verdict.gained, verdict.energy);
    places.emplace_back();
    for (const Body& b : now.bodies.values())
      if (b.motion == Motion::dynamic) places.back().push_back(b.pose.position);
    if (places.size() > kFramesPerSecond) places.pop_front();
  }
  if (ms.empty()) return true;
  judge_times(ms, verdict);
  for (const Trouble& t : troubles) {
    verdict.opening_at_rest = worse(verdict.opening_at_rest, t.opening);
    verdict.turn_at_rest = worse(verdict.turn_at_rest, t.turn);
    verdict.depth_at_rest = worse(verdict.depth_at_rest, t.depth);
  }
  verdict.moved = strayed(places);
  const std::vector<bool> lost = lost_bodies(start, now);
  verdict.lost = static_cast<int>(std::count(lost.begin(), lost.end(), true));
  if (awake_until < verdict.frames) verdict.asleep_after = double(awake_until) / kFramesPerSecond;
  return true;
}

}  // namespace pantin::peers
