#include "engine/modes/uncertain.hpp"

#include <algorithm>
#include <string>

namespace pantin::detail::modes {
namespace {

constexpr Real kLeastMass = 1e-12;

Real below_normal(Real x) { return std::erfc(-x / std::sqrt(2.0)) / 2; }
Real standard(const Spread& s, Real mu) { return (mu - s.mean) / s.deviation; }
/// From low to mu, of the distribution before truncation. Both tails keep their precision.
Real mass(const Spread& s, Real mu) {
  const Real low = standard(s, s.low), x = standard(s, mu);
  return low > 0 ? below_normal(-low) - below_normal(-x) : below_normal(x) - below_normal(low);
}

bool is_certain(const Spread& s) { return s.low == s.high; }

/// SplitMix64: the same sequence everywhere.
struct Generator {
  std::uint64_t state;
  Real next() {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<Real>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
  }
};

struct Mean {
  Real sum = 0, squares = 0;
  int count = 0;

  void add(Real x) { sum += x, squares += x * x, ++count; }
  Probability estimate() const {
    const Real n = count, mean = sum / n;
    const Real variance = std::max(0.0, squares - n * mean * mean) / (n - 1);
    // The rule of three, where all samples agree.
    return {mean, std::max(1.96 * std::sqrt(variance / n), 3 / n), count};
  }
};

std::array<Spread, 3> own_spreads(const Region& r, std::span<const Spread> spreads) {
  std::array<Spread, 3> all;
  for (std::size_t k = 0; k < static_cast<std::size_t>(r.variables()); ++k)
    all[k] = spreads[r.contacts[k]];
  return all;
}

/// Probability over coefficient k, the others as in `mu`.
Real along_axis(const Region& r, const Spread& spread, OwnFriction mu, std::size_t k) {
  Line line{mu, {}};
  line.base[k] = 0, line.along[k] = 1;
  Real sum = 0;
  for (const Interval& part : intervals_along(r, line))
    sum += cumulative(spread, part.high) - cumulative(spread, part.low);
  return sum;
}

/// A rolling contact's force against the sliding one's coefficient x: n0 + n1 x and t0 + t1 x,
/// times X.
struct Rolling {
  Real n0, n1, t0, t1;
};

/// The integral from 0 to h of (t0 + t1 x) / (n0 + n1 x), the divisor of one sign.
Real integral(const Rolling& f, Real h) {
  const auto& [n0, n1, t0, t1] = f;
  const Real z = n1 * h / n0;
  Real first = 1 - z / 2 + z * z / 3, second = 0.5 - z / 3 + z * z / 4;
  if (std::abs(z) > 1e-4) {
    const Real log = std::log1p(z);
    first = log / z, second = (z - log) / (z * z);
  } else {
    first -= z * z * z / 4, second -= z * z * z / 5;
  }
  return h / n0 * (t0 * first + t1 * h * second);
}

/// Integral over x in [from, to] of the feasible range of the rolling contact's coefficient, which
/// is uniform within [low, high].
Real uniform_part(const Rolling& f, const Spread& roll, Real from, Real to) {
  const Real middle = (from + to) / 2;
  const Real least = std::abs(f.t0 + f.t1 * middle) / std::abs(f.n0 + f.n1 * middle);
  if (least <= roll.low) return (roll.high - roll.low) * (to - from);
  if (!(least < roll.high)) return 0;
  const Real lost =
      std::abs(integral({f.n0 + f.n1 * from, f.n1, f.t0 + f.t1 * from, f.t1}, to - from));
  return std::clamp(roll.high * (to - from) - lost, 0.0, (roll.high - roll.low) * (to - from));
}

Real uniform_rolling(const Region& r, const Spread& roll, const Spread& slide) {
  const Rolling f{r.forms[1][1], r.forms[1][3], r.forms[1][0], r.forms[1][2]};
  std::array<Real, 9> at{slide.low, slide.high};
  std::size_t count = 2;
  const auto add = [&](Real constant, Real slope) {
    const Real x = -constant / slope;
    if (x > slide.low && x < slide.high) at[count++] = x;
  };
  add(r.divisor[0], r.divisor[2]);
  add(f.n0, f.n1), add(f.t0, f.t1);
  for (const Real mu : {roll.low, roll.high}) {
    add(f.t0 - mu * f.n0, f.t1 - mu * f.n1);
    add(f.t0 + mu * f.n0, f.t1 + mu * f.n1);
  }
  std::sort(at.begin(), at.begin() + count);
  Real sum = 0;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const Real middle = (at[i] + at[i + 1]) / 2;
    const Real over = r.divisor[0] + r.divisor[2] * middle, normal = f.n0 + f.n1 * middle;
    if (over == 0 || over * normal <= 0 || over * r.forms[0][0] < 0) continue;
    sum += uniform_part(f, roll, at[i], at[i + 1]);
  }
  return sum / ((roll.high - roll.low) * (slide.high - slide.low));
}

bool is_uniform(const Spread& s) { return s.kind == Spread::Kind::uniform && !is_certain(s); }

/// A part of a box in the search of worst_case.
struct Part {
  OwnFriction low, high;
};

OwnFriction corner_of(const Part& part, int corner) {
  OwnFriction m{};
  for (std::size_t i = 0; i < 3; ++i) m[i] = corner >> i & 1 ? part.high[i] : part.low[i];
  return m;
}

/// Halves of the part across its longest side.
std::array<Part, 2> halves(const Part& part) {
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (part.high[i] - part.low[i] > part.high[longest] - part.low[longest]) longest = i;
  std::array<Part, 2> two{part, part};
  two[0].high[longest] = two[1].low[longest] = (part.low[longest] + part.high[longest]) / 2;
  return two;
}

/// Normal forces are monotonic in each coefficient where X is not 0: the largest is at a corner.
Real largest_at_corners(const Region& r, const Part& part) {
  Real largest = 0;
  for (int corner = 0; corner < 1 << r.variables(); ++corner) {
    const auto f = forces(r, corner_of(part, corner));
    largest = std::max({largest, f[0], f[2], r.kind == Kind::three_slide ? f[1] : 0});
  }
  return largest;
}

bool find_with(const Region& r, const Part& part, WorstCase& out) {
  for (int corner = 0; corner < 1 << r.variables(); ++corner)
    if (contains(r, corner_of(part, corner))) {
      out.with = corner_of(part, corner);
      return true;
    }
  return false;
}

/// A point of a box that is not inside. Where all corners are feasible, X is 0 between two of them.
OwnFriction somewhere_without(const Region& r, const Part& part) {
  const OwnFriction first = corner_of(part, 0);
  const int branch = branch_of(r, first);
  OwnFriction other = first;
  for (int corner = 0; corner < 1 << r.variables(); ++corner) {
    const OwnFriction at = corner_of(part, corner);
    const int found = branch_of(r, at);
    if (found == 0) return at;
    if (found != branch) other = at;
  }
  OwnFriction low = first, middle = first;
  for (int i = 0; i < 60; ++i) {
    for (std::size_t k = 0; k < 3; ++k) middle[k] = (low[k] + other[k]) / 2;
    (branch * values(r, middle).divisor > 0 ? low : other) = middle;
  }
  return middle;
}

std::string place(std::size_t i) { return "contact " + std::to_string(i + 1) + ": "; }

}  // namespace

Result<Done> check(std::span<const Spread> spreads, std::size_t contacts) {
  if (spreads.size() != contacts)
    return Error{"found " + std::to_string(spreads.size()) + " spreads of friction, expected " +
                 std::to_string(contacts)};
  std::vector<Error> errors;
  for (std::size_t i = 0; i < contacts; ++i) {
    const Spread& s = spreads[i];
    if (!(s.low >= 0) || !(s.high >= s.low) || !std::isfinite(s.high))
      errors.push_back({place(i) + "friction lies from " + std::to_string(s.low) + " to " +
                        std::to_string(s.high) + ", expected two numbers in order, 0 or more"});
    else if (s.kind == Spread::Kind::normal && !is_certain(s) &&
             (!(s.deviation > 0) || !std::isfinite(s.mean) || !(mass(s, s.high) > kLeastMass)))
      errors.push_back({place(i) + "friction is normal about " + std::to_string(s.mean) + " by " +
                        std::to_string(s.deviation) +
                        ", expected a deviation above 0 and bounds that leave some of it"});
  }
  if (!errors.empty()) return errors;
  return Done{};
}

Real cumulative(const Spread& s, Real mu) {
  if (mu >= s.high) return 1;
  if (mu < s.low) return 0;
  if (s.kind == Spread::Kind::uniform) return (mu - s.low) / (s.high - s.low);
  return mass(s, mu) / mass(s, s.high);
}

Real quantile(const Spread& s, Real part) {
  if (is_certain(s)) return s.low;
  if (s.kind == Spread::Kind::uniform) return s.low + part * (s.high - s.low);
  const Real wanted = part * mass(s, s.high);
  Real low = s.low, high = s.high;
  for (int i = 0; i < 60; ++i) {
    const Real middle = (low + high) / 2;
    (mass(s, middle) < wanted ? low : high) = middle;
  }
  return low;
}

Probability probability(const Region& r, std::span<const Spread> spreads,
                        const Sampling& sampling) {
  const auto own = own_spreads(r, spreads);
  const auto variables = static_cast<std::size_t>(r.variables());
  OwnFriction mu{};
  std::size_t uncertain = 0, last = 0;
  for (std::size_t k = 0; k < variables; ++k) {
    mu[k] = own[k].low;
    if (!is_certain(own[k])) ++uncertain, last = k;
  }
  if (uncertain == 0) return {contains(r, mu) ? 1.0 : 0.0};
  if (uncertain == 1) return {along_axis(r, own[last], mu, last)};
  if (r.kind == Kind::roll_slide && is_uniform(own[0]) && is_uniform(own[1]))
    return {uniform_rolling(r, own[0], own[1])};
  Generator random{sampling.seed};
  Mean mean;
  for (int i = 0; i < sampling.count; ++i) {
    for (std::size_t k = 0; k < last; ++k) mu[k] = quantile(own[k], random.next());
    mean.add(along_axis(r, own[last], mu, last));
  }
  return mean.estimate();
}

Outlook outlook(const Prepared& p, std::span<const Spread> spreads, const Sampling& sampling) {
  Outlook out;
  for (const Region& r : p.regions) out.modes.push_back(probability(r, spreads, sampling));
  Generator random{sampling.seed};
  std::array<Mean, 3> means;
  std::array<Real, kMostContacts> mu;
  const std::span<const Real> all(mu.data(), p.count);
  for (int i = 0; i < sampling.count; ++i) {
    for (std::size_t k = 0; k < p.count; ++k) mu[k] = quantile(spreads[k], random.next());
    int modes = 0;
    for (const Region& r : p.regions) modes += contains(r, own(r, Friction::same(all)));
    for (int k = 0; k < 3; ++k) means[static_cast<std::size_t>(k)].add(std::min(modes, 2) == k);
  }
  out.none = means[0].estimate(), out.unique = means[1].estimate();
  out.ambiguous = means[2].estimate();
  return out;
}

const char* word_for(Occurrence occurrence) {
  constexpr const char* kWords[] = {"always", "sometimes", "never", "unknown"};
  return kWords[static_cast<std::size_t>(occurrence)];
}

WorstCase worst_case(const Region& r, const OwnFriction& low, const OwnFriction& high,
                     int most_boxes) {
  WorstCase out;
  const Part whole{low, high};
  out.boxes = 1;
  if (box(r, low, high) == BoxVerdict::inside) {
    out.occurrence = Occurrence::always, out.with = low;
    out.largest_force = largest_at_corners(r, whole);
    return out;
  }
  out.without = somewhere_without(r, whole);
  std::vector<Part> open{whole};
  for (std::size_t next = 0; next < open.size(); ++next) {
    const Part part = open[next];
    if (find_with(r, part, out)) {
      out.occurrence = Occurrence::sometimes;
      return out;
    }
    if (box(r, part.low, part.high) == BoxVerdict::outside) continue;
    if (out.boxes >= most_boxes) return out;
    for (const Part& half : halves(part)) open.push_back(half), ++out.boxes;
  }
  out.occurrence = Occurrence::never;
  return out;
}

}  // namespace pantin::detail::modes
