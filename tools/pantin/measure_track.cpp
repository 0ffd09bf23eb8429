// Motions at the times of a sampling, and how far two of them are apart.
#include <algorithm>
#include <cmath>

#include "engine/base/rotation.hpp"
#include "engine/geometry/kinds.hpp"
#include "engine/geometry/surface.hpp"
#include "tools/pantin/measure.hpp"

namespace pantin::program {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr Apart kNotApart{0, 0, kUnknown, kUnknown};

/// The distance of the farthest point of a convex shape from the mass centre, m: from all around,
/// towards a farther one each time.
double farthest_of(const Shape& shape) {
  const auto support = traits_of(shape.kind).support;
  double most = 0;
  for (int start = 0; start < 27; ++start) {
    Vec3 at(start % 3 - 1, start / 3 % 3 - 1, start / 9 - 1);
    for (double far = -1; glm::length(at) > far * (1 + 1e-9);) {
      far = far < 0 ? 0 : glm::length(at);
      const Vec3 way = far > 0 ? at : at + Vec3(1e-3, 2e-3, 3e-3);
      at = shape.local.position +
           shape.local.rotation * support(shape, glm::conjugate(shape.local.rotation) * way);
    }
    most = std::max(most, glm::length(at));
  }
  return most;
}

double reach_about_centre(const Shape& shape) {
  if (is_unbounded(shape.kind) || !is_complete(shape)) return 0;
  double most = 0;
  if (shape.surface && !shape.surface->points.empty()) {
    for (const Vec3& p : shape.surface->points)
      most = std::max(most, glm::length(shape.local.position + shape.local.rotation * p));
    return most;
  }
  if (traits_of(shape.kind).support) return farthest_of(shape);
  return glm::length(shape.local.position) + reach_of(shape);
}

double radius_of(const World& world, Entity e) {
  double reach = 0;
  if (const Shapes* shapes = world.shapes.find(e))
    for (const Shape& s : shapes->list) reach = std::max(reach, reach_about_centre(s));
  const Body& b = world.bodies[e];
  if (!(reach > 0)) reach = radius_of_gyration(b.inertia, b.mass);
  return std::isfinite(reach) ? reach : 0;
}

/// Hermite's cubic: the weights of both ends' values and rates, at a part of an interval.
struct Weights {
  double to, rate_from, rate_to;
  explicit Weights(double s)
      : to(s * s * (3 - 2 * s)), rate_from(s * (1 - s) * (1 - s)), rate_to(s * s * (s - 1)) {}
};

double angle_between(const Quat& p, const Quat& q) {
  const Quat turn = p * glm::conjugate(q);
  return 2 * std::atan2(glm::length(Vec3(turn.x, turn.y, turn.z)), std::abs(turn.w));
}

/// The distance of two places of a body. What is not finite is not known.
Apart distance(const Track& track, std::size_t body, const Pose& p, const Pose& q) {
  Apart d = kNotApart;
  const Vec3 between = p.position - q.position, centre = track.centres[body];
  const double angle = angle_between(p.rotation, q.rotation);
  if (const double far = glm::length(between); !std::isnan(far)) d.origin = d.position = far;
  if (std::isnan(angle)) return d;
  d.orientation = angle;
  const double turned = angle * track.radii[body];
  const double far = glm::length(between + p.rotation * centre - q.rotation * centre) + turned;
  d.position = std::isnan(far) ? turned : far;
  return d;
}

Apart larger(const Apart& a, const Apart& b) {
  // The last two may be unknown: NaN.
  return {std::max(a.position, b.position), std::max(a.origin, b.origin),
          std::fmax(a.orientation, b.orientation), std::fmax(a.energy, b.energy)};
}

/// Two motions over their first samples.
class Comparison {
 public:
  Comparison(const Track& a, const Track& b, std::size_t samples) : a_(a), b_(b) {
    for (std::size_t body = 0; body < bodies(); ++body)
      is_unresolved_.push_back(is_unresolved(body, samples));
  }

  /// Over the bodies that are compared at a sample.
  Apart at(std::size_t sample) const {
    Apart d = kNotApart;
    const bool is_step = a_.is_step(sample) && b_.is_step(sample);
    for (std::size_t body = 0; body < bodies(); ++body)
      if (is_step || is_unresolved_[body]) d = larger(d, between(body, sample));
    d.energy = std::abs(a_.energies[sample] - b_.energies[sample]);
    return d;
  }

 private:
  std::size_t bodies() const { return a_.names.size(); }
  Apart between(std::size_t body, std::size_t sample) const {
    const std::size_t i = sample * bodies() + body;
    return distance(a_, body, a_.poses[i], b_.poses[i]);
  }

  /// Whether interpolation between common steps misses more than a tenth of the body's way.
  bool is_unresolved(std::size_t body, std::size_t samples) const {
    constexpr double kMissed = 0.1;
    if (a_.steps % a_.between == 0 && b_.steps % b_.between == 0) return false;
    const Track& finer = a_.steps >= b_.steps ? a_ : b_;
    double missed = 0, way = 0, last = 0, most = 0;
    for (std::size_t s = 1; s < samples; ++s) {
      const std::size_t i = s * bodies() + body;
      way += distance(finer, body, finer.poses[i - bodies()], finer.poses[i]).position;
      const double far = between(body, s).position;
      if (!a_.is_step(s) || !b_.is_step(s)) {
        most = std::max(most, far);
        continue;
      }
      missed += std::max(0.0, most - std::max(last, far));
      last = far, most = 0;
    }
    return missed > kMissed * way;
  }

  const Track &a_, &b_;
  std::vector<bool> is_unresolved_;
};

/// The diagonal of the box around all positions, m; 0 if nothing moves.
double diagonal_of(const Track& track) {
  Vec3 least(std::numeric_limits<double>::infinity()), most = -least;
  for (const Pose& p : track.poses) least = min(least, p.position), most = max(most, p.position);
  const double size = glm::length(most - least);
  return std::isfinite(size) ? size : 0;
}

}  // namespace

Track track_for(const World& world) {
  Track track;
  for (const Entity e : world.bodies.owners()) {
    if (world.bodies[e].motion != Motion::dynamic) continue;
    track.names.push_back(world.name_of(e));
    const Pose* origin = world.origins.find(e);
    track.centres.push_back(origin ? glm::conjugate(origin->rotation) * -origin->position
                                   : Vec3(0));
    track.radii.push_back(radius_of(world, e));
  }
  return track;
}

Sampler::Sampler(const Trial& trial, const World& world, Track& track)
    : track_(track), step_(trial.step) {
  track_ = track_for(world);
  track_.steps = steps_in(trial.sampling.interval, trial.step);
  track_.between = static_cast<std::uint64_t>(trial.sampling.between);
  for (const Entity e : world.bodies.owners())
    if (world.bodies[e].motion == Motion::dynamic) bodies_.push_back(e);
  now_.resize(bodies_.size());
}

/// All bodies at a part of the last step. One that no longer exists stays where it was.
void Sampler::add(const World& world, double part) {
  const Weights w(part);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (!world.bodies.find(bodies_[b])) {
      track_.poses.push_back(track_.poses[track_.poses.size() - bodies_.size()]);
      continue;
    }
    if (part == 1) {
      track_.poses.push_back(world.origin_pose(bodies_[b]));
      continue;
    }
    const State &from = before_[b], &to = now_[b];
    const Vec3 turn = rotation_vector(to.pose.rotation * glm::conjugate(from.pose.rotation));
    Pose pose = from.pose;
    pose.position += w.to * (to.pose.position - from.pose.position) +
                     step_ * (w.rate_from * from.velocity + w.rate_to * to.velocity);
    pose.rotation =
        from_rotation_vector(w.to * turn + step_ * (w.rate_from * from.angular_velocity +
                                                    w.rate_to * to.angular_velocity)) *
        pose.rotation;
    const Pose* origin = world.origins.find(bodies_[b]);
    track_.poses.push_back(origin ? compose(pose, *origin) : pose);
  }
}

void Sampler::take(const World& world, double energy) {
  before_ = now_;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (const Body* body = world.bodies.find(bodies_[b]))
      now_[b] = {body->pose, body->velocity, body->angular_velocity};
  const std::uint64_t steps = track_.steps, end = taken_ * track_.between;
  for (std::uint64_t s = track_.samples(); s * steps <= end; ++s) {
    const bool is_step = s * steps == end;
    // From the step before on.
    add(world, is_step ? 1
                       : static_cast<double>(s * steps + track_.between - end) /
                             static_cast<double>(track_.between));
    track_.energies.push_back(track_.is_step(s) ? energy : kUnknown);
  }
  ++taken_;
}

Apart apart(const Track& a, const Track& b, std::size_t samples) {
  const Comparison both(a, b, samples);
  Apart most = kNotApart;
  for (std::size_t s = 0; s < samples; ++s) most = larger(most, both.at(s));
  return most;
}

std::size_t agreement(const Track& a, const Track& b, double most) {
  const std::size_t samples = std::min(a.samples(), b.samples());
  const Comparison both(a, b, samples);
  for (std::size_t s = 0; s < samples; ++s)
    if (!(both.at(s).position <= most)) return s;
  return samples;
}

double size_of(const Track& track) {
  const double size = diagonal_of(track);
  return size > 0 ? size : 1;
}

double scale_of(const Track& track) {
  const double largest = track.radii.empty() ? 0 : 2 * std::ranges::max(track.radii);
  const double size = std::max(diagonal_of(track), largest);
  return size > 0 ? size : 1;
}

void divide(Sampling& sampling, std::uint64_t longest, std::size_t bodies) {
  constexpr std::uint64_t kParts = 96;  // of the longest step
  constexpr std::size_t kLeast = 200;
  const auto with = [&](std::uint64_t between) {
    Sampling finer = sampling;
    finer.between = static_cast<int>(between);
    return finer;
  };
  // Parts of 2, 4, ..., or 3, 6, ... times the longest steps: the ladders' steps are among them.
  for (std::uint64_t parts = 1; parts <= kParts; parts = parts == 1 ? 3 : 2 * parts) {
    const Sampling finer = with(parts * longest);
    if (finer.samples() * bodies > kMostPoses) break;
    sampling = finer;
  }
  if (sampling.samples() <= kLeast)
    sampling = with(kLeast / static_cast<std::uint64_t>(sampling.count) + 1);
}

}  // namespace pantin::program
