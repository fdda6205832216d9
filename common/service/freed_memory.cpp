#include "common/service/freed_memory.h"

#include <malloc.h>

namespace diaphane::service {

void overwrite_freed_memory() {
  // glibc: freed memory is filled with this byte, and memory that is handed out with its
  // complement, zero. What calloc() hands out and what is mapped for one piece alone is neither.
  mallopt(M_PERTURB, 0xff);
  // Larger pieces are mapped one by one and unmapped when they are freed. By itself the library
  // raises this bound, and each thread keeps the largest piece that it ever had.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
}

}  // namespace diaphane::service
