#pragma once

#include <cstdio>
#include <cstdlib>

/// Ends the fuzzer with a finding, in every build type.
#define MUST(what)                                                            \
  do {                                                                        \
    if (!(what)) {                                                            \
      std::fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #what); \
      std::abort();                                                           \
    }                                                                         \
  } while (false)
