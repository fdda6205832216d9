#include "common/service/freed_memory.h"

#include <malloc.h>

namespace diaphane::service {

void overwrite_freed_memory() {
  // glibc fills freed memory with this byte and allocated memory with its complement, zero. It
  // fills neither memory from calloc() nor blocks with a mapping of their own.
  mallopt(M_PERTURB, 0xff);
  // Larger blocks get a mapping of their own, which is unmapped when they are freed. By default,
  // the library raises this threshold, and each thread keeps the largest block that it ever had.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
}

}  // namespace diaphane::service
