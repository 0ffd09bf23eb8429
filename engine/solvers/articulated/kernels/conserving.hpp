#pragma once
/// A whole step of a tree of free ball joints by the energy-momentum method, solved by Newton
/// iterations in the rotations of the bodies.
///
/// A rigid body is described by its mass centre and three material directions d_k with masses J_k
/// (the principal second moments, kg m^2). Joints are linear in these coordinates and rigidity is
/// quadratic, so that the mid-point rule with the constraint gradients at the mean of the two
/// poses conserves energy, momentum and angular momentum. [Betsch & Steinmann 2001, "Constrained
/// integration of rigid body dynamics"] The mean velocity of the step, V = (z1 - z0) / h, satisfies
///
///   (V - v0 - h f / 2) . dz = 0   for every displacement dz that the joints and rigidity allow
///
/// at the mean of the poses z0 and z1, with the masses as weights. The velocity at the end, 2 V -
/// v0, is projected to those that joints and rigidity allow there, which can only remove energy.
/// Nothing depends on the ratio of a body's moments of inertia: thin bodies are no special case.
///
/// The unknowns of an iteration are the rotation of each body (rad) and the displacement of its
/// own joint point (m). Bodies are eliminated from the leaves to the roots, in linear time.
#include "engine/solvers/articulated/kernels/conserving_iterate.hpp"

namespace pantin::detail::articulated {
namespace {

/// The step of the islands that `Lanes` holds; see the top of the file.
template <class Lanes>
struct ConservingStep : ConservingIterate<Lanes> {
  using Iterate = ConservingIterate<Lanes>;
  using Iterate::constants, Iterate::work, Iterate::memory, Iterate::parent, Iterate::count;
  using Iterate::due_, Iterate::work_, Iterate::weight_, Iterate::probe_, Iterate::turned2_;
  using Iterate::lanes, Iterate::in, Iterate::h, Iterate::h4, Iterate::per, Iterate::kNumber;
  using typename Iterate::N;
  using typename Iterate::P;
  /// Largest share of an error that an iteration with kept matrices may leave.
  static constexpr double kKeepsWell = 0.03;
  /// Length of the Cayley vector of a rotation by 2 rad.
  static constexpr double kMostTurned = 3.11;

  /// State of the iterations of an island.
  struct Course {
    bool runs = true, solved = false;
    double largest2 = 0;  // square of the largest rotation of the last iteration, rad^2
    double since = 0;     // rad: sum of the largest rotations since the matrices were renewed
    Factor next = Factor::renewed;
    int kept = 0;            // iterations since then
    bool keeps_well = true;  // they have converged so far
    double released = 0;     // J, by joints and ties
    AtEnd at_end = AtEnd::keeps;
  };

  ConservingStep(Lanes& islands, const ConservingInput& common) : Iterate(islands, common) {
    for_each_island([&](Course& c, int l) { c.runs = lanes.is_used(l); });
  }

  Course course[Lanes::kIslands];

  template <class Do>
  void for_each_island(const Do& act) {
    for (int l = 0; l < Lanes::kIslands; ++l) act(course[l], l);
  }
  bool any_runs() const {
    for (const Course& c : course)
      if (c.runs) return true;
    return false;
  }
  bool any_solved() const {
    for (const Course& c : course)
      if (c.solved) return true;
    return false;
  }
  enum class End : bool { failed, solved };
  void stop(int island, End end) {
    course[island].runs = false, course[island].solved = end == End::solved;
    lanes.stop(island);
  }

  /// The matrices of the next iteration of all islands that run.
  Factor next_factor() const {
    bool renewed = false, kept = false;
    for (const Course& c : course)
      if (c.runs) (c.next == Factor::kept ? kept : renewed) = true;
    return renewed && kept ? Factor::mixed : kept ? Factor::kept : Factor::renewed;
  }
  /// After an iteration: whether the next one, by its prediction, has nothing to do, and its
  /// matrices. With new ones it rotates by about the square of this one; with kept ones by the
  /// product of this one and of all since their renewal, or by the share that the last one left of
  /// the one before. Matrices are kept where two more iterations with them are enough.
  bool is_near(Course& c, int l, double before2, int n) {
    const ConservingInput& own = lanes.input(l);
    const double largest = ::sqrt(c.largest2), before = ::sqrt(before2);
    double left = largest;
    if (c.next == Factor::kept) {
      c.since += largest, left = c.since;
      if (c.kept++ > 0 && largest > left * before) left = largest / before;
      c.keeps_well = left < kKeepsWell;
    } else {
      c.since = largest, c.kept = 0;
    }
    const double enough = own.enough * own.enough;
    const double most = own.enough_next > enough ? own.enough_next : enough;
    const bool keeps = own.may_keep && c.keeps_well && left * left * left * largest < most;
    c.next = keeps ? Factor::kept : Factor::renewed;
    lanes.choose_factor(l, c.next);
    return left * largest < enough || (n > 0 && c.largest2 < own.enough_next * before);
  }

  /// One Newton iteration: eliminates, solves for the unknowns, rotates the bodies.
  void iterate(Factor factor) {
    if (lanes.has_ties()) lanes.load_ties();
    this->template inward<Unknown::displacement>(factor);
    const double* held = lanes.ways();
    if constexpr (Lanes::kHooks)
      if (in.joints) in.joints->outward(in.joints->context, Unknown::displacement);
    for (std::size_t i = 0; !in.joints && i < count(); ++i)
      this->template outward<Unknown::displacement>(i, held);
    bool fails[Lanes::kIslands] = {};
    if (lanes.has_ties()) lanes.correct_ties(fails);
    for_each_island([&](Course& c, int l) {
      if (c.runs && fails[l]) stop(l, End::failed);
    });
    P most = all<P>(0);
    typename Lanes::Sum probe;
    for (std::size_t i = 0; i < count(); i += Lanes::kAtOnce) {
      double* k = work(i);
      Vec<P> t = vec<P>(memory(i), kTurnBy);
      const P t2 = lanes.mask_of(i) * dot(t, t);
      most = choose(t2 > most, t2, most), probe.add(i, t2);
      t = choose(t2 > 1.0, 1.0 / root(t2), all<P>(1.0)) * t;
      const Qua<P> before = qua<P>(k, kEndRotation);
      put(k, kEndRotation,
          lanes.running(unit(mul(Qua<P>{0.5 * t.x, 0.5 * t.y, 0.5 * t.z, all<P>(1)}, before)),
                        before));
    }
    const N sums = probe.total(), largests = Lanes::largest_of(most);
    for_each_island([&](Course& c, int l) {
      if (!c.runs) return;
      c.largest2 = Lanes::of_island(sums, l) < HUGE_VAL ? Lanes::of_island(largests, l) : HUGE_VAL;
      if (!(c.largest2 < 1e6)) stop(l, End::failed);
    });
  }

  void fill_for(Factor factor) {
    if (factor == Factor::kept)
      this->template fill_all<Unknown::displacement, Factor::kept>();
    else if (factor == Factor::mixed)
      this->template fill_all<Unknown::displacement, Factor::mixed>();
    else
      this->template fill_all<Unknown::displacement>();
  }

  /// Newton iterations of all islands.
  void solve() {
    for (std::size_t i = 0; i < count(); i += Lanes::kAtOnce) this->guess(i);
    const N found = probe_.total();
    for_each_island([&](Course&, int l) {
      if (!(Lanes::of_island(found, l) < HUGE_VAL)) stop(l, End::failed);
    });
    this->template fill_all<Unknown::displacement>();
    Factor factor = Factor::renewed;
    for (int n = 0; n < in.most_iterations && any_runs(); ++n) {
      double before2[Lanes::kIslands];
      bool near[Lanes::kIslands] = {};
      for_each_island([&](Course& c, int l) { before2[l] = c.largest2; });
      iterate(factor);
      for_each_island([&](Course& c, int l) { near[l] = c.runs && is_near(c, l, before2[l], n); });
      move_roots();
      for_each_island([&](Course&, int l) {
        if (near[l] && !lanes.has_ties()) stop(l, End::solved);
      });
      if (!any_runs()) break;
      factor = next_factor();
      fill_for(factor);
      if (lanes.has_ties()) lanes.settle_ties(near);
      for_each_island([&](Course&, int l) {
        if (near[l]) stop(l, End::solved);
      });
    }
    for_each_island([&](Course& c, int l) {
      if (c.runs) stop(l, End::failed);
    });
  }
  /// Moves free roots by their displacements.
  void move_roots() {
    for (std::size_t i = 0; i < count(); ++i)
      if (parent(i) == kFree) {
        double* k = work(i);
        const Vec<N> before = vec<N>(k, kJointWay);
        put(k, kJointWay, lanes.running(before + vec<N>(memory(i), kMove), before));
      }
  }

  /// Gives a free tree its exact momentum: distributes the residual of the iterations as the same
  /// velocity for all its bodies.
  void balance(std::size_t first, std::size_t last) {
    Vec<N> lacks{N{}, N{}, N{}};
    N mass{};
    for (std::size_t i = first; i < last; ++i) {
      const double* c = constants(i);
      const N m = num<N>(c, kMass), weight = h * num<N>(c, kGravityScale);
      Vec<N> v = lanes.velocity(i);
      v = v + Vec<N>{weight * in.gravity[0], weight * in.gravity[1], weight * in.gravity[2]};
      if (const double* f = lanes.forces(i)) v = v + h * vec<N>(f, 0);
      lacks = lacks + (m * v - vec<N>(work(i), kImpulse));
      mass += m;
    }
    const Vec<N> change = (lanes.inner_ties() / mass) * lacks;
    for (std::size_t i = first; i < last; ++i) {
      double* k = work(i);
      const Vec<N> gain = num<N>(constants(i), kMass) * change;
      put(k, kImpulse, vec<N>(k, kImpulse) + gain);
      put(k, kTorqueImpulse, vec<N>(k, kTorqueImpulse) - cross(vec<N>(k, kEndArm), gain));
      if (i == first) put(k, kJointWay, vec<N>(k, kJointWay) + (0.5 * h) * change);
    }
  }
  void balance_free_trees() {
    for (std::size_t first = 0, last = 0; first < count(); first = last) {
      last = first + 1;
      while (last < count() && parent(last) >= 0) ++last;
      if (parent(first) == kFree) balance(first, last);
    }
  }

  /// J: twice the work at the anchors of the roots, by their impulses over the displacements
  /// `moved`, m, or at the end velocities `moved`, m/s.
  N anchor_work(const double* moved, N share) const {
    N sum{};
    for (std::size_t i = 0; i < count(); ++i) {
      if (parent(i) >= 0) continue;
      if (parent(i) == kHeld) sum += share * dot(vec<N>(memory(i), kLambda), get_vec<N>(moved, 0));
      moved += 3 * kNumber;
    }
    return sum;
  }

  /// Rejects solutions in which a body rotated by more than 2 rad, since Newton's method may have
  /// found a spurious root, and those that ties or limits do not accept.
  void refuse() {
    const N turned2 = Lanes::largest_of(turned2_);
    for_each_island([&](Course& c, int l) {
      if (!c.solved) return;
      if (lanes.input(l).divisible && Lanes::of_island(turned2, l) > kMostTurned * kMostTurned)
        c.solved = false;
      else if (lanes.has_ties() && !lanes.accept_ties(l, c.released))
        c.solved = false;
      else if (!lanes.accept_limits(l))
        c.solved = false;
      if constexpr (Lanes::kHooks)
        if (c.solved && in.joints) c.at_end = in.joints->add_work(in.joints->context, c.released);
    });
  }

  /// Projects the velocities at the end.
  void project() {
    balance_free_trees();
    this->template inward<Unknown::velocity>();
    if constexpr (Lanes::kHooks)
      if (in.joints) in.joints->outward(in.joints->context, Unknown::velocity);
    const double *held = lanes.anchor_velocities(), *target = lanes.targets();
    for (std::size_t i = 0; i < count(); ++i) {
      if (!in.joints) this->template outward<Unknown::velocity>(i, held);
      put_joint(i, target);
    }
    bool wanted[Lanes::kIslands], fails[Lanes::kIslands] = {};
    for_each_island([&](Course& c, int l) { wanted[l] = c.solved; });
    if (lanes.has_ties()) lanes.project_ties(wanted, fails);
    for_each_island([&](Course& c, int l) { c.solved = c.solved && !fails[l]; });
  }

  /// Twice the energies of an island, J.
  struct Energies {
    double due, found, works, weight;
    double by_anchors;
  };
  /// False if the step gains energy without a source, or loses too much; else the factor of the
  /// velocities. The projection removes energy of second order in the step. Below an anchor at
  /// rest, velocities are scaled to the energy that is due, by a tenth at most: beyond that the
  /// step does not resolve the motion, and shorter ones are tried. The projection impulses do the
  /// work at anchors that belongs to the anchors' end velocities.
  bool scales(const Course& c, int l, Energies e, double& factor) const {
    const ConservingInput& own = lanes.input(l);
    if (!own.knows_work || c.at_end == AtEnd::drives) return true;
    const bool struck = lanes.is_struck(l);  // an impact dissipates energy, it adds none
    const bool still = own.still && !struck;
    const double by_places = 2 * lanes.place_work(l);
    const double due = e.due + 2 * c.released + e.by_anchors + by_places;
    const double rounding = still ? 0 : 1e-3 * (e.works + ::fabs(e.by_anchors) + ::fabs(by_places));
    // Beyond rounding errors of the weight's work.
    const bool moves = e.found > 1e-10 * e.weight;
    if (moves && !(due + rounding >= (1 - own.most_gain) * e.found)) return false;
    if (c.at_end != AtEnd::keeps) return true;
    if (moves && !struck && due > own.most_due * e.found) return false;
    if (moves && still) factor = due < 1.2 * e.found ? ::sqrt(due / e.found) : ::sqrt(1.2);
    return true;
  }

  /// Writes back the islands whose step is accepted, and nothing of the others.
  void finish() {
    if constexpr (Lanes::kHooks)
      if (in.joints) in.joints->align(in.joints->context);
    this->template fill_all<Unknown::velocity>();
    refuse();
    if (!any_solved()) return;
    const N by_ways = anchor_work(lanes.ways(), 4.0 * per);
    const N at_end = anchor_work(lanes.anchor_velocities(), N{} + 4.0);
    project();
    typename Lanes::Sum kept;
    for (std::size_t i = 0; i < count(); i += Lanes::kAtOnce) kept.add(i, twice_kinetic(i));
    const N by_anchors = by_ways + anchor_work(lanes.anchor_velocities(), N{} + 4.0) - at_end;
    const N due = due_.total(), found = kept.total(), works = work_.total(),
            weight = weight_.total();
    const auto of = [](N x, int l) { return Lanes::of_island(x, l); };
    double factors[Lanes::kIslands];
    for_each_island([&](Course& c, int l) {
      factors[l] = 1;
      const Energies e{of(due, l), of(found, l), of(works, l), of(weight, l), of(by_anchors, l)};
      c.solved = c.solved && scales(c, l, e, factors[l]);
      lanes.set_outcome(l, c.solved ? LaneOutcome::taken : LaneOutcome::refused);
    });
    if (!lanes.any_taken()) return;
    const P factor = Lanes::factors_of(factors);
    for (std::size_t i = 0; i < count(); i += Lanes::kAtOnce) write_back(i, factor);
  }
  /// Twice the kinetic energy of a block by its projected velocities, J.
  INLINE P twice_kinetic(std::size_t i) const {
    const double* k = work(i);
    const double* c = constants(i);
    const double* m = memory(i);
    const Vec<P> w = vec<P>(m, kTurnBy);
    const Vec<P> v = vec<P>(m, kMove) + cross(w, vec<P>(k, kEndArm));
    const Vec<P> l = times_inertia(qua<P>(k, kEndRotation), vec<P>(c, kInertia), w);
    return lanes.mask_of(i) * (num<P>(c, kMass) * dot(v, v) + dot(l, w));
  }
  /// Position of the joint of body i at the end.
  INLINE void put_joint(std::size_t i, const double*& target) const {
    double* k = work(i);
    Vec<N> joint;
    if (parent(i) >= 0)
      joint = vec<N>(work(static_cast<std::size_t>(parent(i))), kEndJoint) + vec<N>(k, kEndReach);
    else if (parent(i) == kHeld)
      joint = get_vec<N>(target, 0);
    else
      joint = lanes.position(i) - (2.0 * vec<N>(k, kMeanArm) - vec<N>(k, kEndArm)) +
              vec<N>(k, kJointWay);
    if (parent(i) < 0) target += 3 * kNumber;
    put(k, kEndJoint, joint);
  }
  INLINE void write_back(std::size_t i, P factor) {
    const double* k = work(i);
    double* m = memory(i);
    const BodyLayout& at = lanes.p.layout;
    const P keep = lanes.half_drag(i);
    const Vec<P> x = vec<P>(k, kEndJoint) + vec<P>(k, kEndArm);
    const Qua<P> q = qua<P>(k, kEndRotation);
    const Vec<P> w = factor * vec<P>(m, kTurnBy);
    const Vec<P> v = keep * (factor * vec<P>(m, kMove) + cross(w, vec<P>(k, kEndArm)));
    const Vec<P> turned = vec<P>(m, kTurned);  // by 2 atan(t / 2) = t - t^3 / 12 + t^5 / 80
    const P t2 = dot(turned, turned);
    put(m, kLastRotation, (1.0 - t2 * (1.0 / 12) + t2 * t2 * (1.0 / 80)) * turned);
    put(m, kLastTranslation, x - lanes.start(i).x);
    put(m, kLambda, (2.0 * h4) * vec<P>(m, kLambda));
    lanes.set_bodies(i, at.position, x);
    lanes.set_bodies(i, at.rotation, Vec<P>{q.x, q.y, q.z});
    lanes.set_bodies(i, at.rotation + 3, q.w);
    lanes.set_bodies(i, at.velocity, v);
    lanes.set_bodies(i, at.angular_velocity, keep * w);
  }
};

template <class Lanes>
void conserve_by(Lanes& lanes, const ConservingInput& in) {
  ConservingStep<Lanes> step(lanes, in);
  step.solve();
  if (step.any_solved()) step.finish();
}

bool conserve(const IslandView& p, const ConservingInput& in) {
  BodyLanes lanes(p, in);
  conserve_by(lanes, in);
  // The other passes expect an identity rotation in the padding.
  for (std::size_t i = p.count; i % kLanes != 0; ++i)
    put(column(p.work, kWorkRows, i), kAppliedRotation, Qua<double>{0, 0, 0, 1});
  clear_padding(p);
  return lanes.any_taken();
}

}  // namespace
}  // namespace pantin::detail::articulated
