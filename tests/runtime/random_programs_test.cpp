// Random programs over the public interface end in errors and statuses, and the Worlds that they
// leave can be saved and read again. The fuzz target `api_fuzz` finds such programs; here are some
// for every day, the same each time.
#include <catch2/catch.hpp>
#include <random>

#include "tests/fuzz/random_program.hpp"

using namespace pantin::test::random_program;

namespace {

void run(std::uint32_t seed) {
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::vector<std::uint8_t> bytes(200 + random() % 1000);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  REQUIRE_NOTHROW(Program(Bytes(bytes.data(), bytes.size())).run());
}

}  // namespace

TEST_CASE("random programs end in errors and statuses, and what they save can be read") {
  for (std::uint32_t seed = 1; seed <= 400; ++seed) run(seed);
  run(22894);  // what moves at 1e298 m/s beside something was asked whether it slides past
}
