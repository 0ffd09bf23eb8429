#include "engine/modes/prepare.hpp"

#include <algorithm>

#include "engine/base/check.hpp"

namespace pantin::detail::modes {
namespace {

constexpr Real kSingular = 1e-12;    // of a determinant, relative to the lengths of its rows
constexpr Real kStandstill = 1e-11;  // of a velocity, relative to the fastest finger

Real det(Vec3 a, Vec3 b, Vec3 c) { return glm::dot(a, glm::cross(b, c)); }

void take_frame(const Lamina& lamina, Prepared& p) {
  Vec2 sum;
  for (const Contact& c : lamina.contacts) sum.x += c.point.x, sum.y += c.point.y;
  const Real n = static_cast<Real>(p.count);
  p.centre = {sum.x / n, sum.y / n};
  Real far2 = 0, speed = 0;
  for (const Contact& c : lamina.contacts) {
    const Vec2 d{c.point.x - p.centre.x, c.point.y - p.centre.y};
    far2 = std::max(far2, dot(d, d));
    speed = std::max({speed, std::abs(c.velocity.x), std::abs(c.velocity.y)});
  }
  p.scale = far2 > 0 ? std::sqrt(far2) : 1;
  p.speed = speed > 0 ? speed : 1;
}

Vec3 unit_wrench(const Prepared& p, Vec2 point, Vec2 along) {
  const Vec2 arm{(point.x - p.centre.x) / p.scale, (point.y - p.centre.y) / p.scale};
  return {along.x, along.y, cross(arm, along)};
}

void take_wrenches(const Lamina& lamina, Prepared& p) {
  for (std::size_t i = 0; i < p.count; ++i) {
    const Contact& c = lamina.contacts[i];
    const Vec2 t = tangent_of(c.normal);
    p.normal[i] = unit_wrench(p, c.point, c.normal);
    p.tangent[i] = unit_wrench(p, c.point, t);
    p.normal_velocity[i] = dot(c.normal, c.velocity) / p.speed;
    p.tangent_velocity[i] = dot(t, c.velocity) / p.speed;
  }
  const Vec2 force{lamina.load.x, lamina.load.y};
  p.load = {force.x, force.y, (lamina.load.z - cross(p.centre, force)) / p.scale};
}

/// The equations of a motion: three rows, and their right sides.
struct Rows {
  Vec3 a, b, c;
  Real da, db, dc;
};

/// The motion under trial.
struct Trial {
  Vec3 twist;
  Real determinant;
  Real standstill;  // below this a velocity is 0
  std::array<Real, 3> slip;
};

bool solve(const Rows& m, Trial& t) {
  const Vec3 bc = glm::cross(m.b, m.c), ca = glm::cross(m.c, m.a), ab = glm::cross(m.a, m.b);
  t.determinant = glm::dot(m.a, bc);
  const Real rows2 = glm::dot(m.a, m.a) * glm::dot(m.b, m.b) * glm::dot(m.c, m.c);
  if (t.determinant * t.determinant <= kSingular * kSingular * rows2) return false;
  const Real inverse = 1 / t.determinant;
  t.twist = (m.da * bc + m.db * ca + m.dc * ab) * inverse;
  const Vec3 size = glm::abs(t.twist);
  t.standstill = kStandstill + 1e-15 * (size.x + size.y + size.z);
  return true;
}

Kinematics judge(const Prepared& p, std::uint32_t kept, Trial& t) {
  bool tie = false;
  for (std::size_t m = 0; m < p.count; ++m) {
    if (kept >> m & 1) continue;
    const Real gap_rate = glm::dot(p.normal[m], t.twist) - p.normal_velocity[m];
    if (gap_rate < -t.standstill) return Kinematics::penetrates;
    tie |= gap_rate <= t.standstill;
  }
  for (const Real slip : t.slip)
    if (std::abs(slip) < t.standstill) return Kinematics::zero_slip;
  return tie ? Kinematics::break_tie : Kinematics::ok;
}

Real slip_of(const Prepared& p, std::size_t i, const Trial& t) {
  return glm::dot(p.tangent[i], t.twist) - p.tangent_velocity[i];
}

/// Determinants of wrenches are proportional to length.
void scale(Region& r, Real length) {
  for (Real& x : r.divisor) x *= length;
  for (auto& f : r.forms)
    for (Real& x : f) x *= length;
  r.determinant *= length;
}

/// Columns a_i = w_in and b_i = -xi_i w_it; D, C, B, A of X and G, F, E of the Y.
void three_slide_forms(const Prepared& p, Region& r) {
  std::array<std::array<Vec3, 2>, 3> x;
  for (std::size_t k = 0; k < 3; ++k)
    x[k] = {p.normal[r.contacts[k]], -static_cast<Real>(r.slip_sign[k]) * p.tangent[r.contacts[k]]};
  const Vec3 h = -p.load;
  for (std::size_t high = 0; high < 2; ++high)
    for (std::size_t low = 0; low < 2; ++low) {
      const std::size_t at = low + 2 * high;
      const Vec3 c23 = glm::cross(x[1][low], x[2][high]);
      r.divisor[2 * low + 4 * high] = glm::dot(x[0][0], c23);
      r.divisor[2 * low + 4 * high + 1] = glm::dot(x[0][1], c23);
      r.forms[0][at] = glm::dot(h, c23);
      r.forms[1][at] = glm::dot(h, glm::cross(x[2][high], x[0][low]));
      r.forms[2][at] = glm::dot(h, glm::cross(x[0][low], x[1][high]));
    }
}

void roll_slide_forms(const Prepared& p, Region& r) {
  const std::size_t roll = r.contacts[0], slide = r.contacts[1];
  const Vec3 rn = p.normal[roll], rt = p.tangent[roll], sn = p.normal[slide];
  const Vec3 b = -static_cast<Real>(r.slip_sign[1]) * p.tangent[slide], h = -p.load;
  const Vec3 rolling = glm::cross(rn, rt);
  const Real c1 = det(h, rt, b), d1 = det(h, rt, sn), c2 = det(rn, h, b), d2 = det(rn, h, sn);
  r.divisor = {glm::dot(rolling, sn), 0, glm::dot(rolling, b), 0, 0, 0, 0, 0};
  r.forms[0] = {glm::dot(rolling, h), 0, 0, 0};
  r.forms[1] = {d2, d1, c2, c1};
  r.forms[2] = {-d2, d1, -c2, c1};
  r.forms[3] = {d1, 0, c1, 0};
}

void keep(Prepared& p, Candidate& c, const Trial& t) {
  c.region = static_cast<std::int32_t>(p.regions.size());
  Region& r = p.regions.emplace_back();
  r.kind = c.kind, r.contacts = c.contacts;
  r.break_tie = c.status == Kinematics::break_tie;
  r.determinant = t.determinant;
  r.twist = to_world(p, t.twist);
  const auto sign = [](Real x) { return static_cast<std::int8_t>(x < 0 ? -1 : 1); };
  if (c.kind == Kind::three_slide) {
    for (std::size_t k = 0; k < 3; ++k)
      r.slip[k] = t.slip[k] * p.speed, r.slip_sign[k] = sign(t.slip[k]);
    three_slide_forms(p, r);
  } else {
    r.slip[1] = t.slip[1] * p.speed, r.slip_sign[1] = sign(t.slip[1]);
    roll_slide_forms(p, r);
  }
  scale(r, p.scale);
}

void finish(Prepared& p, Candidate& c, const Rows& rows) {
  Trial t;
  if (!solve(rows, t)) {
    c.status = Kinematics::singular;
  } else {
    std::uint32_t kept = 0;
    const bool slides = c.kind == Kind::three_slide;
    for (std::size_t k = 0; k < (slides ? 3u : 2u); ++k) kept |= 1u << c.contacts[k];
    const Real one = slip_of(p, c.contacts[1], t);
    t.slip = {one, one, one};
    if (slides) t.slip[0] = slip_of(p, c.contacts[0], t), t.slip[2] = slip_of(p, c.contacts[2], t);
    c.status = judge(p, kept, t);
    if (c.status == Kinematics::ok || c.status == Kinematics::break_tie) keep(p, c, t);
  }
  ++p.found[static_cast<std::size_t>(c.status)];
}

void add_three_slide(Prepared& p, std::array<std::uint8_t, 3> contacts) {
  const auto [i, j, k] = contacts;
  Candidate& c = p.candidates.emplace_back();
  c.contacts = contacts;
  finish(p, c,
         {p.normal[i], p.normal[j], p.normal[k], p.normal_velocity[i], p.normal_velocity[j],
          p.normal_velocity[k]});
}

void add_roll_slide(Prepared& p, std::uint8_t roll, std::uint8_t slide) {
  Candidate& c = p.candidates.emplace_back();
  c.kind = Kind::roll_slide, c.contacts = {roll, slide, 0};
  finish(p, c,
         {p.normal[roll], p.tangent[roll], p.normal[slide], p.normal_velocity[roll],
          p.tangent_velocity[roll], p.normal_velocity[slide]});
}

std::string letters(std::size_t count, Kind kind, const std::array<std::uint8_t, 3>& contacts) {
  std::string name(count, 'B');
  for (std::size_t k = 0; k < (kind == Kind::three_slide ? 3u : 2u); ++k) name[contacts[k]] = 'S';
  if (kind == Kind::roll_slide) name[contacts[0]] = 'R';
  return name;
}

}  // namespace

const char* word_for(Kinematics status) {
  constexpr const char* kWords[] = {"ok", "break_tie", "penetrates", "zero_slip", "singular"};
  return kWords[static_cast<std::size_t>(status)];
}

Vec3 to_world(const Prepared& p, Vec3 twist) {
  const Real turn = twist.z * p.speed / p.scale;
  return {twist.x * p.speed + turn * p.centre.y, twist.y * p.speed - turn * p.centre.x, turn};
}

void prepare(const Lamina& lamina, Prepared& p) {
  PANTIN_ASSERT(!lamina.contacts.empty() && lamina.contacts.size() <= kMostContacts);
  p.count = lamina.contacts.size();
  p.candidates.clear(), p.regions.clear();
  p.found = {};
  take_frame(lamina, p);
  take_wrenches(lamina, p);
  const auto n = static_cast<std::uint8_t>(p.count);
  p.candidates.reserve(p.count * (p.count - 1) * (p.count + 4) / 6);
  for (std::uint8_t i = 0; i < n; ++i)
    for (auto j = static_cast<std::uint8_t>(i + 1); j < n; ++j)
      for (auto k = static_cast<std::uint8_t>(j + 1); k < n; ++k) add_three_slide(p, {i, j, k});
  for (std::uint8_t i = 0; i < n; ++i)
    for (std::uint8_t j = 0; j < n; ++j)
      if (i != j) add_roll_slide(p, i, j);
}

std::string name_of(const Prepared& p, const Candidate& c) {
  return letters(p.count, c.kind, c.contacts);
}
std::string name_of(const Prepared& p, const Region& r) {
  return letters(p.count, r.kind, r.contacts);
}

std::string short_name(const Prepared& p, const Region& r) {
  const auto number = [&](std::size_t k) { return std::to_string(r.contacts[k] + 1); };
  if (r.kind == Kind::roll_slide) return "R" + number(0) + "S" + number(1);
  if (p.count == 3) return "3S";
  return "S" + number(0) + "S" + number(1) + "S" + number(2);
}

}  // namespace pantin::detail::modes
