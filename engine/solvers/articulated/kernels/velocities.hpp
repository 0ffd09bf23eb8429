#pragma once
/// Velocities from the final poses, alone or together with the outward pass.
#include "engine/solvers/articulated/kernels/outward.hpp"
#include "engine/solvers/articulated/kernels/predict.hpp"

namespace pantin::detail::articulated {
namespace {

/// Velocities of one block from its final pose, written to the bodies; accumulates sums.
template <Rule rule>
struct VelocityUpdate {
  const IslandView& p;
  const VelocityInput& in;
  const double per = 1 / in.h;
  const Vec<Four> g{all(in.gravity[0]), all(in.gravity[1]), all(in.gravity[2])};
  Four kinetic = all(0), potential = all(0), work = all(0), turned = all(0);
  Vec<Four> momentum{all(0), all(0), all(0)};
  bool sane = true;
  DampingFactor damping{0.5 * in.h};

  INLINE void operator()(std::size_t i, Vec<Four> x, Qua<Four> q) {
    const std::size_t lanes = p.count - i < kLanes ? p.count - i : kLanes;
    const Four here = mask(i, p.count);
    if (any_not_below(dot(x, x), kTooFar * kTooFar)) {
      sane = false;
      return;
    }
    const double* c = column(p.constants, kConstantRows, i);
    double* m = column(p.memory, kMemoryRows, i);
    const double* k = column(p.work, kWorkRows, i);
    const FourBodies bodies(p, i);
    const Vec<Four> moments = vec<Four>(c, kInertia);
    const Vec<Four> translation = x - bodies.vec(p.layout.position);
    const Vec<Four> turned_by = logarithm(mul(q, back(bodies.qua(p.layout.rotation))));
    const Four turned2 = here * dot(turned_by, turned_by);
    turned = choose(turned2 > turned, turned2, turned);

    Vec<Four> v, w, l;
    if (rule == Rule::verlet || rule == Rule::midpoint) {
      v = all(per) * translation, w = all(per) * turned_by;
      if (rule == Rule::midpoint) l = times_inertia(q, moments, w);
    } else if (in.first) {
      // Trapezoidal rule from the initial velocities, stored by predict(), between two halves of
      // the drag.
      const Four keep = damping.of(num<Four>(c, kDrag));
      v = all(2 * per) * translation - keep * vec<Four>(m, kVelocityBefore);
      w = all(2 * per) * turned_by - keep * bodies.vec(p.layout.angular_velocity);
      l = times_inertia(q, moments, w);
      work -= 0.5 * here * (1.0 - keep * keep) * (num<Four>(c, kMass) * dot(v, v) + dot(l, w));
      v = keep * v, w = keep * w, l = keep * l;
    } else {
      // Differences of rotation vectors would lose an order of accuracy: the rotation caused by the
      // joints is an impulse on the predicted angular momentum.
      const double rate = rule == Rule::bdf2 ? 1.5 * per : per;
      v = rule == Rule::bdf2
              ? all(0.5 * per) * (all(3) * translation - vec<Four>(m, kLastTranslation))
              : all(per) * translation;
      const Qua<Four> predicted = qua<Four>(k, kRotation);
      const Vec<Four> forced = logarithm(mul(q, back(predicted)));
      l = times_inertia(predicted, moments,
                        vec<Four>(k, kAngularVelocityStar) + all(rate) * forced);
      w = times_inertia(q, inverted(moments), l);
      if (rule == Rule::euler && any_not_below(turned2, in.calm_angle * in.calm_angle)) {
        // A large rotation: its rate is bounded, the impulse is not.
        const Four calm2 = all(in.calm_angle * in.calm_angle);
        const Vec<Four> plain = all(per) * turned_by;
        w.x = choose(turned2 >= calm2, plain.x, w.x);
        w.y = choose(turned2 >= calm2, plain.y, w.y);
        w.z = choose(turned2 >= calm2, plain.z, w.z);
        l = times_inertia(q, moments, w);
      }
    }
    bodies.set(p.layout.position, x, lanes);
    bodies.set(p.layout.rotation, Vec<Four>{q.x, q.y, q.z}, lanes);
    bodies.set(p.layout.rotation + 3, q.w, lanes);
    bodies.set(p.layout.velocity, v, lanes);
    bodies.set(p.layout.angular_velocity, w, lanes);
    if (rule == Rule::verlet) return;  // no energy balance

    put(m, kLastTranslation, translation), put(m, kLastRotation, turned_by);
    const Four mass = num<Four>(c, kMass);
    const Vec<Four> weight = num<Four>(c, kGravityScale) * g;
    kinetic += 0.5 * here * (mass * dot(v, v) + dot(l, w));
    potential -= here * mass * dot(weight, x);
    momentum = momentum + (here * mass) * v;
    if (p.forces) {
      const double* f = column(p.forces, 6, i);
      work += here * (mass * dot(vec<Four>(f, 0), translation) + dot(vec<Four>(f, 3), turned_by));
    }
  }

  EndSums sums() const {
    return {sum(kinetic),    sum(potential),
            sum(work),       {sum(momentum.x), sum(momentum.y), sum(momentum.z)},
            largest(turned), sane};
  }
};

template <class Job>
EndSums by_rule(const IslandView& p, const VelocityInput& in, const Job& job) {
  const auto run = [&](auto update_velocities) {
    job(update_velocities);
    return update_velocities.sums();
  };
  switch (in.rule) {
    case Rule::verlet:
      return run(VelocityUpdate<Rule::verlet>{p, in});
    case Rule::midpoint:
      return run(VelocityUpdate<Rule::midpoint>{p, in});
    case Rule::euler:
      return run(VelocityUpdate<Rule::euler>{p, in});
    case Rule::bdf2:
      return run(VelocityUpdate<Rule::bdf2>{p, in});
  }
  return {};
}

EndSums update_velocities(const IslandView& p, const VelocityInput& in) {
  return by_rule(p, in, [&](auto& update_block) {
    for (std::size_t i = 0; i < p.count; i += kLanes) {
      const double* k = column(p.work, kWorkRows, i);
      update_block(i, vec<Four>(k, kFinalPosition), qua<Four>(k, kFinalRotation));
    }
  });
}

/// The outward pass is sequential; vector work on neighbouring blocks hides its latency. The next
/// block is prepared and the previous one gets poses and velocities, one job per body.
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

EndSums outward_pass_and_update(const IslandView& p, const double* targets,
                                const VelocityInput& in) {
  return by_rule(p, in, [&](auto& update_block) {
    const auto prepared = [](std::size_t) {};
    if (p.is_chain)
      walk_and_update<true>(Articulated{p, kPosition}, targets, prepared, update_block);
    else
      walk_and_update<false>(Articulated{p, kPosition}, targets, prepared, update_block);
  });
}

EndSums sweep_and_update(const IslandView& p, const double* targets, double stiffness,
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
