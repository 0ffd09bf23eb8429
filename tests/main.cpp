// Catch's own main lives alone here: it takes seconds to compile.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
