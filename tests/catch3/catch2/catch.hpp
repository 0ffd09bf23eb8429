#pragma once
// Catch2 3 by the name and the words of Catch2 2, which the tests are written in. On the include
// path only where version 3 was found.
#include <catch2/catch_all.hpp>

using Catch::Approx;

#ifdef CATCH_CONFIG_MAIN
int main(int argc, char* argv[]) { return Catch::Session().run(argc, argv); }
#endif
