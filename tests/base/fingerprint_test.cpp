// The 64-bit fingerprint: equal bits, equal numbers; anything else, another number.
#include <bit>
#include <catch2/catch.hpp>
#include <set>

#include "engine/base/hash.hpp"

using namespace pantin;
using namespace pantin::detail;

namespace {

template <class... T>
std::uint64_t of(const T&... values) {
  Hash hash;
  (hash.add(values), ...);
  return hash.value();
}

}  // namespace

TEST_CASE("the same values in the same order give the same fingerprint") {
  const Pose pose{{1, 2, 3}, {0.5, 0.5, -0.5, 0.5}};
  CHECK(of(1.5, pose, true, std::string_view("name")) ==
        of(1.5, pose, true, std::string_view("name")));
  CHECK(of(1.0, 2.0) != of(2.0, 1.0));
  CHECK(of() != of(0.0));
  CHECK(of(0.0) != of(0.0, 0.0));
}

TEST_CASE("the last bit of a number shows, and so does the sign of zero") {
  CHECK(of(1.0) != of(std::nextafter(1.0, 2.0)));
  CHECK(of(0.0) != of(-0.0));
  CHECK(of(Vec3(1, 2, 3)) != of(Vec3(1, 2, std::nextafter(3.0, 4.0))));
  CHECK(of(Quat(1, 0, 0, 0)) != of(Quat(-1, 0, 0, 0)));
}

TEST_CASE("texts are told apart where one ends") {
  CHECK(of(std::string_view("ab"), std::string_view("c")) !=
        of(std::string_view("a"), std::string_view("bc")));
  CHECK(of(std::string_view("")) != of());
}

TEST_CASE("a hundred thousand neighbouring numbers have as many fingerprints") {
  std::set<std::uint64_t> seen;
  for (std::uint64_t i = 0; i < 50000; ++i)
    seen.insert(of(i)), seen.insert(of(1.0 + 1e-9 * static_cast<Real>(i)));
  CHECK(seen.size() == 100000);
}

TEST_CASE("one bit of the input turns over about half of the fingerprint") {
  Real total = 0;
  int least = 64;
  for (int bit = 0; bit < 64; ++bit) {
    const std::uint64_t before = of(std::uint64_t(12345), std::uint64_t(678)),
                        after = of(std::uint64_t(12345) ^ (std::uint64_t(1) << bit),
                                   std::uint64_t(678));
    const int rotated = std::popcount(before ^ after);
    total += rotated, least = std::min(least, rotated);
  }
  CHECK(total / 64 > 28);
  CHECK(total / 64 < 36);
  CHECK(least >= 8);
}
