#include "tools/study/surface_forms.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "engine/base/rotation.hpp"
#include "engine/nurbs/common_normal.hpp"
#include "engine/nurbs/makers.hpp"

namespace pantin::study {
namespace {

using nurbs::PlacePair;

constexpr std::size_t kMostRows = 5;
/// A row whose gradient is shorter binds nothing.
constexpr Real kNoRow = 1e-6;

/// A body that rolls on a surface that stands or turns steadily about the origin.
struct Case {
  const char* name;
  nurbs::Skin on_a, on_b;
  Real mass = 1;
  Vec3 inertia{1};
  Pose start;
  Vec3 velocity{0}, spin{0}, gravity{0}, turns{0};  // m/s, rad/s, m/s^2, rad/s of the surface
  Vec3 end{0};                                      // m, where the mass centre is after a second
};

struct State {
  Pose pose;
  Vec3 v{0}, w{0};
};
using Six = std::array<Real, 6>;  // of velocity and angular velocity, or of a way and a turn

Pose moved(const Pose& p, const Six& by, Real part) {
  return {p.position + part * Vec3(by[0], by[1], by[2]),
          glm::normalize(from_rotation_vector(part * Vec3(by[3], by[4], by[5])) * p.rotation)};
}

/// Rows at a state: J by the body's and by the surface's motion, gamma, and what is open.
struct Rows {
  std::size_t count = 0;
  std::array<Six, kMostRows> a{}, b{};
  std::array<Real, kMostRows> gamma{};
  Real gap = 0;
};

class Rolling {
 public:
  Rolling(const Case& of, SurfaceForm form, Real step) : of_(of), form_(form), h_(step) {
    const Pose b = surface_at(0);
    nurbs::CommonNormal found[4];
    const nurbs::Meeting meeting{of.on_a, of.on_b, compose(inverse(b), of.start)};
    if (nurbs::find_contacts(meeting, 1, found) > 0) place_ = found[0].at;
    state_ = {of.start, of.velocity, of.spin};
  }

  void advance(Real time, Real h);
  const State& state() const { return state_; }

 private:
  bool is_paper() const {
    return form_ == SurfaceForm::paper_central || form_ == SurfaceForm::paper_richardson;
  }
  bool extrapolates() const {
    return form_ == SurfaceForm::gap_richardson || form_ == SurfaceForm::paper_richardson;
  }
  Pose surface_at(Real time) const { return {Vec3(0), from_rotation_vector(time * of_.turns)}; }
  Six twist_a(const State& s) const { return {s.v.x, s.v.y, s.v.z, s.w.x, s.w.y, s.w.z}; }
  Six twist_b() const { return {0, 0, 0, of_.turns.x, of_.turns.y, of_.turns.z}; }

  nurbs::CommonNormal track(const Pose& a, const Pose& b) const {
    return nurbs::track({of_.on_a, of_.on_b, compose(inverse(b), a)}, place_);
  }
  std::array<Real, 3> values_at(const Pose& a, const Pose& b) const;
  Rows rows_at(const Pose& a, const Pose& b) const;
  Rows analytic(const State& s, const Pose& b) const;
  Rows rows(const State& s, Real time);
  Six accelerations(const Rows& rows, const State& s) const;
  Six correction(const Rows& rows, const State& s, std::array<Real, kMostRows> right) const;
  void project(Real time);

  const Case& of_;
  SurfaceForm form_;
  Real h_;  // of the differences, m and rad
  PlacePair place_;
  State state_;
};

/// The gap; or C_p = |d|^2 and C_tan, a's tangents along b's normal.
std::array<Real, 3> Rolling::values_at(const Pose& a, const Pose& b) const {
  const nurbs::CommonNormal now = track(a, b);
  if (!is_paper()) return {now.gap, 0, 0};
  const Pose rel = compose(inverse(b), a);
  const nurbs::Jet p = of_.on_a.face(now.at.a.face).at(now.at.a.u, now.at.a.v);
  const Vec3 d = now.on_a - now.on_b;
  return {glm::dot(d, d), glm::dot(rel.rotation * p.u, now.normal),
          glm::dot(rel.rotation * p.v, now.normal)};
}

/// J by differences over the coordinates of both bodies; C_roll is linear in the velocities.
Rows Rolling::rows_at(const Pose& a, const Pose& b) const {
  Rows out;
  const std::size_t values = is_paper() ? 3 : 1;
  out.count = values + 2;
  for (std::size_t k = 0; k < 12; ++k) {
    Six one{};
    one[k % 6] = 1;
    const auto difference = [&](Real h) {
      const auto at = [&](Real part) {
        return k < 6 ? values_at(moved(a, one, part), b) : values_at(a, moved(b, one, part));
      };
      const auto ahead = at(h), back = at(-h);
      return std::array{(ahead[0] - back[0]) / (2 * h), (ahead[1] - back[1]) / (2 * h),
                        (ahead[2] - back[2]) / (2 * h)};
    };
    auto d = difference(h_);
    if (extrapolates()) {
      const auto wide = difference(2 * h_);
      for (std::size_t i = 0; i < 3; ++i) d[i] = (4 * d[i] - wide[i]) / 3;
    }
    for (std::size_t i = 0; i < values; ++i) (k < 6 ? out.a : out.b)[i][k % 6] = d[i];
  }
  const nurbs::CommonNormal now = track(a, b);
  const nurbs::Jet p = of_.on_a.face(now.at.a.face).at(now.at.a.u, now.at.a.v);
  const Vec3 place = to_world(b, now.on_a);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3 t = glm::normalize(a.rotation * (i == 0 ? p.u : p.v));
    const auto row = [&](Vec3 centre, Real sign) {
      const Vec3 turn = glm::cross(place - centre, t);
      return Six{sign * t.x, sign * t.y, sign * t.z, sign * turn.x, sign * turn.y, sign * turn.z};
    };
    out.a[values + i] = row(a.position, 1), out.b[values + i] = row(b.position, -1);
  }
  out.gap = now.gap;
  return out;
}

Rows Rolling::analytic(const State& s, const Pose& b) const {
  const Pose rel = compose(inverse(b), s.pose);
  const nurbs::Meeting meeting{of_.on_a, of_.on_b, rel};
  const nurbs::CommonNormal now = nurbs::track(meeting, place_);
  const Vec3 wb = of_.turns, origin = s.pose.position;
  const Quat back = glm::conjugate(b.rotation);
  const nurbs::Moving m = nurbs::moving(
      meeting, now.at, {back * (s.v - glm::cross(wb, origin - b.position)), back * (s.w - wb)});
  const Vec3 n = b.rotation * now.normal, n_rate = glm::cross(wb, n) + b.rotation * m.normal;
  const Vec3 ra = to_world(b, now.on_a) - origin, rb = to_world(b, now.on_b) - b.position;
  const Vec3 v = s.v + glm::cross(s.w, ra) - glm::cross(wb, rb);
  const Vec3 bend = glm::cross(s.w, glm::cross(s.w, ra) + b.rotation * m.on_a) -
                    glm::cross(wb, glm::cross(wb, rb) + b.rotation * m.on_b);
  Rows out;
  out.count = 3, out.gap = now.gap;
  const auto set = [&](std::size_t i, Vec3 along, Vec3 rate) {
    const Vec3 turn_a = glm::cross(ra, along), turn_b = glm::cross(rb, along);
    out.a[i] = {along.x, along.y, along.z, turn_a.x, turn_a.y, turn_a.z};
    out.b[i] = {-along.x, -along.y, -along.z, -turn_b.x, -turn_b.y, -turn_b.z};
    out.gamma[i] = -(glm::dot(rate, v) + glm::dot(along, bend));
  };
  set(0, n, n_rate);
  const Vec3 side = std::abs(n.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 across = side - glm::dot(n, side) * n;
  const Vec3 t = glm::normalize(across);
  const Vec3 across_rate = -(glm::dot(n_rate, side) * n + glm::dot(n, side) * n_rate);
  const Vec3 t_rate = (across_rate - glm::dot(t, across_rate) * t) / glm::length(across);
  set(1, t, t_rate), set(2, glm::cross(n, t), glm::cross(n_rate, t) + glm::cross(n, t_rate));
  return out;
}

/// Rows with gamma, which the differences find along the motion.
Rows Rolling::rows(const State& s, Real time) {
  const Pose b = surface_at(time);
  if (const nurbs::CommonNormal now = track(s.pose, b); now.status == nurbs::ContactStatus::found)
    place_ = now.at;
  if (form_ == SurfaceForm::analytic) return analytic(s, b);
  Rows out = rows_at(s.pose, b);
  const Six va = twist_a(s), vb = twist_b();
  const Real speed =
      std::max({Real(1), glm::length(s.v), glm::length(s.w), glm::length(of_.turns)});
  const auto rates = [&](Real eps) {
    const auto at = [&](Real part) {
      const Rows r = rows_at(moved(s.pose, va, part), moved(b, vb, part));
      std::array<Real, kMostRows> sum{};
      for (std::size_t i = 0; i < r.count; ++i)
        for (std::size_t k = 0; k < 6; ++k) sum[i] += r.a[i][k] * va[k] + r.b[i][k] * vb[k];
      return sum;
    };
    auto ahead = at(eps);
    const auto back = at(-eps);
    for (std::size_t i = 0; i < kMostRows; ++i) ahead[i] = (ahead[i] - back[i]) / (2 * eps);
    return ahead;
  };
  auto change = rates(h_ / speed);
  if (extrapolates()) {
    const auto wide = rates(2 * h_ / speed);
    for (std::size_t i = 0; i < kMostRows; ++i) change[i] = (4 * change[i] - wide[i]) / 3;
  }
  for (std::size_t i = 0; i < out.count; ++i) out.gamma[i] = -change[i];
  return out;
}

/// The least motion, by the masses, whose rows are `right`; rows without a gradient bind nothing.
Six Rolling::correction(const Rows& r, const State& s, std::array<Real, kMostRows> right) const {
  const Mat3 turn = glm::mat3_cast(s.pose.rotation);
  const auto give = [&](const Six& row) {
    const Vec3 own = Vec3(row[3], row[4], row[5]) * turn;
    const Vec3 w = turn * (own / of_.inertia);
    return Six{row[0] / of_.mass, row[1] / of_.mass, row[2] / of_.mass, w.x, w.y, w.z};
  };
  std::array<Six, kMostRows> moves;
  Real m[kMostRows][kMostRows] = {}, lambda[kMostRows] = {};
  bool binds[kMostRows] = {};
  for (std::size_t i = 0; i < r.count; ++i) {
    moves[i] = give(r.a[i]);
    Real size = 0;
    for (const Real x : r.a[i]) size += x * x;
    binds[i] = size > kNoRow * kNoRow;
  }
  for (std::size_t i = 0; i < r.count; ++i)
    for (std::size_t j = 0; j < r.count; ++j)
      for (std::size_t k = 0; k < 6; ++k) m[i][j] += r.a[i][k] * moves[j][k];
  for (std::size_t p = 0; p < r.count; ++p) {
    if (!binds[p]) continue;
    for (std::size_t i = p + 1; i < r.count; ++i) {
      if (!binds[i]) continue;
      const Real part = m[i][p] / m[p][p];
      for (std::size_t j = p; j < r.count; ++j) m[i][j] -= part * m[p][j];
      right[i] -= part * right[p];
    }
  }
  for (std::size_t p = r.count; p-- > 0;) {
    if (!binds[p]) continue;
    lambda[p] = right[p];
    for (std::size_t j = p + 1; j < r.count; ++j) lambda[p] -= m[p][j] * lambda[j];
    lambda[p] /= m[p][p];
  }
  Six out{};
  for (std::size_t i = 0; i < r.count; ++i)
    for (std::size_t k = 0; k < 6; ++k) out[k] += lambda[i] * moves[i][k];
  return out;
}

Six Rolling::accelerations(const Rows& r, const State& s) const {
  const Quat back = glm::conjugate(s.pose.rotation);
  const Vec3 own = back * s.w;
  const Vec3 w = s.pose.rotation * (-glm::cross(own, of_.inertia * own) / of_.inertia);
  Six free{of_.gravity.x, of_.gravity.y, of_.gravity.z, w.x, w.y, w.z};
  std::array<Real, kMostRows> right = r.gamma;
  for (std::size_t i = 0; i < r.count; ++i)
    for (std::size_t k = 0; k < 6; ++k) right[i] -= r.a[i][k] * free[k];
  const Six by = correction(r, s, right);
  for (std::size_t k = 0; k < 6; ++k) free[k] += by[k];
  return free;
}

/// Poses by the gap, by the form's own gradient; then velocities.
void Rolling::project(Real time) {
  Rows r;
  for (int n = 0; n < 4; ++n) {
    r = form_ == SurfaceForm::analytic ? analytic(state_, surface_at(time))
                                       : rows_at(state_.pose, surface_at(time));
    if (is_paper() || std::abs(r.gap) <= 1e-13) break;
    Rows one = r;
    one.count = 1;
    state_.pose = moved(state_.pose, correction(one, state_, {-r.gap}), 1);
  }
  const Six va = twist_a(state_), vb = twist_b();
  std::array<Real, kMostRows> right{};
  for (std::size_t i = 0; i < r.count; ++i)
    for (std::size_t k = 0; k < 6; ++k) right[i] -= r.a[i][k] * va[k] + r.b[i][k] * vb[k];
  const Six by = correction(r, state_, right);
  state_.v += Vec3(by[0], by[1], by[2]), state_.w += Vec3(by[3], by[4], by[5]);
}

void Rolling::advance(Real time, Real h) {
  constexpr Real kPart[] = {0, 0.5, 0.5, 1}, kWeight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  const State from = state_;
  Vec3 x(0), v(0), w(0), dx(0), dv(0), dw(0);
  Quat q(0, 0, 0, 0), dq(0, 0, 0, 0);
  for (int i = 0; i < 4; ++i) {
    const Real part = kPart[i] * h;
    State s{{from.pose.position + part * dx, glm::normalize(from.pose.rotation + part * dq)},
            from.v + part * dv,
            from.w + part * dw};
    const Six a = accelerations(rows(s, time + part), s);
    dx = s.v, dv = {a[0], a[1], a[2]}, dw = {a[3], a[4], a[5]};
    dq = Quat(0, 0.5 * s.w) * s.pose.rotation;
    x += kWeight[i] * dx, v += kWeight[i] * dv, w += kWeight[i] * dw, q += kWeight[i] * dq;
  }
  state_ = {{from.pose.position + h * x, glm::normalize(from.pose.rotation + h * q)},
            from.v + h * v,
            from.w + h * w};
  project(time + h);
}

std::vector<Case> cases() {
  std::vector<Case> all;
  constexpr Real kRate = 3, kRadius = 0.1, kTurn = 2.0 / 7 * kRate;
  const Vec3 start(0.5, 0, kRadius), speed(0.2, -0.4, 0);
  // z is up. Without slip: v - w x (r up) = the table's velocity there.
  const Vec3 slip = speed - glm::cross(Vec3(0, 0, kRate), start);
  const Real s = std::sin(kTurn) / kTurn, c = (1 - std::cos(kTurn)) / kTurn;
  const auto flat = [] { return nurbs::Skin({nurbs::plane({}, 10, 10)}, 1e-9); };
  all.push_back({"turntable",
                 nurbs::Skin({nurbs::sphere({{}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, kRadius)}, 1e-9),
                 flat(),
                 1,
                 Vec3(0.4 * kRadius * kRadius),
                 {start, kIdentity},
                 speed,
                 glm::cross(Vec3(0, 0, 1), slip) / kRadius,
                 {0, 0, -9.81},
                 {0, 0, kRate},
                 start + Vec3(s * speed.x - c * speed.y, s * speed.y + c * speed.x, 0)});
  // Numbers of the closed form of a steady turn.
  all.push_back({"wheel",
                 nurbs::Skin({nurbs::torus({}, 0.4, 0.1)}, 1e-9),
                 flat(),
                 1,
                 {0.05, 0.05, 0.09},
                 {{0.5355941332790835, 0, 0.47281563438689056},
                  Quat(0.8253356149096783, 0, 0.5646424733950354, 0)},
                 {0, 1.071188266558167, 0},
                 {-2.5721097967198503, 0, 1.0000162608635152},
                 {0, 0, -9.81},
                 {0, 0, 0},
                 {-0.22288580423729915, 0.4870143672136018, 0.47281563438689056}});
  return all;
}

constexpr std::pair<SurfaceForm, const char*> kForms[] = {
    {SurfaceForm::analytic, "analytic"},
    {SurfaceForm::gap_central, "gap_central"},
    {SurfaceForm::gap_richardson, "gap_richardson"},
    {SurfaceForm::paper_central, "paper_central"},
    {SurfaceForm::paper_richardson, "paper_richardson"}};

}  // namespace

std::optional<SurfaceForm> form_named(std::string_view name) {
  for (const auto& [form, known] : kForms)
    if (name == known) return form;
  return std::nullopt;
}

void measure_surface_forms(std::FILE* out, FormSteps steps, std::optional<SurfaceForm> only) {
  const bool small = steps == FormSteps::few;
  const int count = small ? 20 : 100;
  std::fprintf(out, "method,difference,error,us_a_step\n");
  for (const Case& of : cases())
    for (const auto& [form, name] : kForms) {
      if (only && form != *only) continue;
      for (int n = 1; n <= 7; ++n) {
        if ((form == SurfaceForm::analytic && n > 1) || (small && n != 1 && n != 4)) continue;
        const Real difference = form == SurfaceForm::analytic ? 0 : std::pow(10, -n);
        Rolling body(of, form, difference);
        const double from = cpu_seconds();
        for (int i = 0; i < count; ++i) body.advance(Real(i) / count, Real(1) / count);
        const double cost = (cpu_seconds() - from) / count * 1e6;
        std::fprintf(out, "%s_%s,%g,%.2e,%.1f\n", of.name, name, difference,
                     glm::distance(body.state().pose.position, of.end), cost);
        std::fflush(out);
      }
    }
}

}  // namespace pantin::study
