#pragma once
/// PANTIN_ASSERT: programming errors abort the program, in Debug builds and in tests.
///
/// Internal (pantin::detail); installed because stores assert with it.
#include <cstdio>
#include <cstdlib>

#if !defined(NDEBUG) || defined(PANTIN_CHECKED)
#define PANTIN_ASSERT(condition)                                                           \
  do {                                                                                     \
    if (!(condition)) {                                                                    \
      std::fprintf(stderr, "%s:%d: this must hold: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                        \
    }                                                                                      \
  } while (false)
#else
#define PANTIN_ASSERT(condition) static_cast<void>(0)
#endif
