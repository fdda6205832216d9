#include "ingest/pipeline/memory_shortage.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <limits>
#include <new>
#include <optional>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DIAPHANE_OWN_NEW 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || \
    __has_feature(memory_sanitizer)
#define DIAPHANE_OWN_NEW 0
#endif
#endif
#ifndef DIAPHANE_OWN_NEW
#define DIAPHANE_OWN_NEW 1
#endif

namespace diaphane::ingest {
namespace {

std::optional<int> exit_code_when_short;

#if DIAPHANE_OWN_NEW
/// Returns whether the limit on address space refuses this many bytes. The test mapping cannot be
/// touched, so it uses address space but no memory, and the machine does not refuse it.
bool limit_refuses(std::size_t bytes) {
  // The allocator maps at least 1 MiB and rounds up.
  constexpr std::size_t kMore = std::size_t{2} << 20;
  if (bytes > std::numeric_limits<std::size_t>::max() - kMore) return true;
  void* const mapping =
      mmap(nullptr, bytes + kMore, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (mapping == MAP_FAILED) return true;
  munmap(mapping, bytes + kMore);
  return false;
}
#endif

}  // namespace

void end_when_machine_is_short_of_memory(int exit_code) { exit_code_when_short = exit_code; }

}  // namespace diaphane::ingest

#if DIAPHANE_OWN_NEW
void* operator new(std::size_t bytes) {
  for (;;) {
    if (void* const got = std::malloc(bytes > 0 ? bytes : 1)) return got;
    if (const std::new_handler handler = std::get_new_handler()) {
      handler();
      continue;
    }
    using namespace diaphane::ingest;
    if (exit_code_when_short && !limit_refuses(bytes)) _exit(*exit_code_when_short);
    throw std::bad_alloc();
  }
}

void operator delete(void* pointer) noexcept { std::free(pointer); }
void operator delete(void* pointer, std::size_t /*bytes*/) noexcept { std::free(pointer); }
#endif
