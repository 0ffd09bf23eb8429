// Random programs over the public interface: see random_program.hpp.
#include "tests/fuzz/random_program.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pantin::test::random_program;
  Program(Bytes(data, size)).run();
  return 0;
}
