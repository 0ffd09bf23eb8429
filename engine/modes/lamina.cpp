#include "engine/modes/lamina.hpp"

#include <string>

namespace pantin::detail::modes {
namespace {

bool is_finite(Vec2 v) { return std::isfinite(v.x) && std::isfinite(v.y); }
std::string text(Vec2 v) { return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ")"; }
std::string contact_name(std::size_t i) { return "contact " + std::to_string(i + 1) + ": "; }
bool same(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }

void check_contact(std::span<const Contact> all, std::size_t i, std::vector<Error>& errors) {
  const Contact& c = all[i];
  if (!is_finite(c.point)) errors.push_back({contact_name(i) + "point is not finite"});
  if (!is_finite(c.velocity)) errors.push_back({contact_name(i) + "velocity is not finite"});
  if (!(std::abs(dot(c.normal, c.normal) - 1) < 2e-6))
    errors.push_back(
        {contact_name(i) + "normal is " + text(c.normal) + ", expected a vector of length 1"});
  for (std::size_t j = 0; j < i; ++j)
    if (same(all[j].point, c.point) && same(all[j].normal, c.normal))
      errors.push_back({contact_name(i) + "repeats contact " + std::to_string(j + 1) +
                        ", expected another point or normal"});
}

void check_coefficients(const char* name, std::span<const Real> mu, std::vector<Error>& errors) {
  for (std::size_t i = 0; i < mu.size(); ++i)
    if (!(mu[i] >= 0) || !std::isfinite(mu[i]))
      errors.push_back({contact_name(i) + name + " friction is " + std::to_string(mu[i]) +
                        ", expected 0 or more"});
}

}  // namespace

Result<Done> check(const Lamina& lamina) {
  std::vector<Error> errors;
  const std::size_t n = lamina.contacts.size();
  if (n == 0 || n > kMostContacts)
    return Error{"found " + std::to_string(n) + " contacts, expected 1 to " +
                 std::to_string(kMostContacts)};
  for (std::size_t i = 0; i < n; ++i) check_contact(lamina.contacts, i, errors);
  if (!pantin::is_finite(lamina.load))
    errors.push_back({"load is not finite"});
  else if (lamina.load == Vec3(0))
    errors.push_back({"load is 0: without a load every admissible mode holds with zero force"});
  if (!errors.empty()) return errors;
  return Done{};
}

Result<Done> check(const Friction& friction, std::size_t contacts) {
  std::vector<Error> errors;
  for (const auto& mu : {friction.roll, friction.slide})
    if (mu.size() != contacts)
      return Error{"found " + std::to_string(mu.size()) + " coefficients of friction, expected " +
                   std::to_string(contacts)};
  check_coefficients("rolling", friction.roll, errors);
  check_coefficients("sliding", friction.slide, errors);
  if (!errors.empty()) return errors;
  return Done{};
}

}  // namespace pantin::detail::modes
