#pragma once
/// Velocities from the final poses, alone or in one loop with the sweep.
#include "engine/solvers/articulated/kernels/predict.hpp"
#include "engine/solvers/articulated/kernels/sweep.hpp"

namespace pantin::detail::articulated {
namespace {

/// Velocities of one block from its final pose, written to the bodies.
template <Rule rule>
struct VelocityUpdate {
  const IslandView& p;
  const VelocityInput& in;
  const double per = 1 / in.h;
  bool sane = true;

  INLINE void operator()(std::size_t i, Vec<Four> x, Qua<Four> q) {
    const std::size_t lanes = p.count - i < kLanes ? p.count - i : kLanes;
    if (any_not_below(dot(x, x), kTooFar * kTooFar)) {
      sane = false;
      return;
    }
    const FourBodies bodies(p, i);
    const Vec<Four> translation = x - bodies.vec(p.layout.position);
    const Vec<Four> turned_by = logarithm(mul(q, back(bodies.qua(p.layout.rotation))));
    const Vec<Four> w = rule == Rule::euler ? kept_spin(i, q, turned_by) : all(per) * turned_by;
    bodies.set(p.layout.position, x, lanes);
    bodies.set(p.layout.rotation, Vec<Four>{q.x, q.y, q.z}, lanes);
    bodies.set(p.layout.rotation + 3, q.w, lanes);
    bodies.set(p.layout.velocity, all(per) * translation, lanes);
    bodies.set(p.layout.angular_velocity, w, lanes);
    if (rule == Rule::verlet) return;
    double* m = column(p.memory, kMemoryRows, i);
    put(m, kLastTranslation, translation), put(m, kLastRotation, turned_by);
  }

  /// Treats the rotation by the joints as an impulse on the predicted angular momentum: differences
  /// of rotation vectors would lose an order of accuracy. Large rotations use their mean rate,
  /// which is bounded; the impulse is not.
  INLINE Vec<Four> kept_spin(std::size_t i, Qua<Four> q, Vec<Four> turned_by) {
    constexpr double kLarge = 0.5;  // rad
    const Vec<Four> moments = vec<Four>(column(p.constants, kConstantRows, i), kInertia);
    const double* k = column(p.work, kWorkRows, i);
    const Qua<Four> predicted = qua<Four>(k, kRotation);
    const Vec<Four> forced = logarithm(mul(q, back(predicted)));
    const Vec<Four> l =
        times_inertia(predicted, moments, vec<Four>(k, kAngularVelocityStar) + all(per) * forced);
    Vec<Four> w = times_inertia(q, inverted(moments), l);
    const Vec<Four> plain = all(per) * turned_by;
    const auto large = dot(turned_by, turned_by) >= all(kLarge * kLarge);
    w.x = choose(large, plain.x, w.x), w.y = choose(large, plain.y, w.y);
    w.z = choose(large, plain.z, w.z);
    return w;
  }
};

template <class Job>
bool by_rule(const IslandView& p, const VelocityInput& in, const Job& job) {
  const auto run = [&](auto update_velocities) {
    job(update_velocities);
    return update_velocities.sane;
  };
  switch (in.rule) {
    case Rule::verlet:
      return run(VelocityUpdate<Rule::verlet>{p, in});
    case Rule::midpoint:
      return run(VelocityUpdate<Rule::midpoint>{p, in});
    case Rule::euler:
      return run(VelocityUpdate<Rule::euler>{p, in});
  }
  return false;
}

bool update_velocities(const IslandView& p, const VelocityInput& in) {
  return by_rule(p, in, [&](auto& update_block) {
    for (std::size_t i = 0; i < p.count; i += kLanes) {
      const double* k = column(p.work, kWorkRows, i);
      update_block(i, vec<Four>(k, kFinalPosition), qua<Four>(k, kFinalRotation));
    }
  });
}

/// The sweep is sequential; vector work on neighbouring blocks hides its latency: one job per body
/// prepares the next block, or computes poses or velocities of the previous one.
template <bool chain, class Rotate, class Prepare, class Block>
INLINE void walk_and_update(const Rotate& rotate, const double* targets,
                            const Prepare& prepare_block, Block& update_block) {
  const IslandView& p = rotate.p;
  const auto put_pose = [&](std::size_t i) {
    double* k = column(p.work, kWorkRows, i);
    const BlockPose at = pose_of(p, i, kRotation);
    put(k, kFinalRotation, at.q), put(k, kFinalPosition, at.x);
  };
  const auto update_placed = [&](std::size_t i) {
    const double* k = column(p.work, kWorkRows, i);
    update_block(i, vec<Four>(k, kFinalPosition), qua<Four>(k, kFinalRotation));
  };
  Step at;
  prepare_block(0);
  for (std::size_t n = 0; n < p.count; ++n) {
    outwards<chain>(rotate, targets, n, at);
    const std::size_t job = n % kLanes, i = n - job;
    if (job == 0 && i + kLanes < p.count) prepare_block(i + kLanes);
    if (job == 1 && i > 0) put_pose(i - kLanes);
    if (job == 2 && i > 0) update_placed(i - kLanes);
  }
  const std::size_t last = (p.count - 1) / kLanes * kLanes;
  if (last > 0 && p.count - last < 2) put_pose(last - kLanes);
  if (last > 0 && p.count - last < 3) update_placed(last - kLanes);
  put_pose(last);
  update_placed(last);
}

bool sweep_and_update(const IslandView& p, const double* targets, double stiffness,
                      const VelocityInput& in) {
  return by_rule(p, in, [&](auto& update_block) {
    const LeastDisplacement rotate{p, kPosition, stiffness};
    const auto prepare_block = [&](std::size_t i) { put_levers(p, i, kPosition, kRotation); };
    if (p.is_chain)
      walk_and_update<true>(rotate, targets, prepare_block, update_block);
    else
      walk_and_update<false>(rotate, targets, prepare_block, update_block);
  });
}

void scale(const IslandView& p, double factor, const double* mean) {
  for (std::size_t i = 0; i < p.count; ++i) {
    double* b = p.bodies + p.slots[i] * p.layout.stride;
    for (std::size_t n = 0; n < 3; ++n) {
      double& v = b[p.layout.velocity + n];
      v = mean[n] + factor * (v - mean[n]);
      b[p.layout.angular_velocity + n] *= factor;
    }
  }
}

}  // namespace
}  // namespace pantin::detail::articulated
