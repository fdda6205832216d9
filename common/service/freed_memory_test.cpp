#include "common/service/freed_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace diaphane::service {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kOwnAllocator = true;
#else
constexpr bool kOwnAllocator = false;
#endif

/// Whether `wanted` can be read at `place`.
bool still_there(const void* place, const std::string& wanted) {
  // Reads through the kernel, because the place may be unmapped by now.
  std::FILE* const memory = std::fopen("/proc/self/mem", "rb");
  std::string found(wanted.size(), '\0');
  const bool mapped = std::fseek(memory, static_cast<long>(reinterpret_cast<std::uintptr_t>(place)),
                                 SEEK_SET) == 0 &&
                      std::fread(found.data(), 1, found.size(), memory) == found.size();
  std::fclose(memory);
  return mapped && found == wanted;
}

TEST(FreedMemory, IsOverwritten) {
  if (kOwnAllocator) GTEST_SKIP() << "a sanitizer's allocator";
  overwrite_freed_memory();
  // Tests the middle of blocks in sizes that uploads and volumes use.
  for (const std::size_t bytes : {2000U, 20000U, 200000U, 900000U, 8000000U}) {
    std::string mark = "canary";
    mark += std::to_string(bytes);
    auto* piece = new std::vector<char>(bytes);
    auto* neighbour = new std::vector<char>(bytes);  // keeps it from being the end of the heap
    char* const place = piece->data() + bytes / 2;
    std::copy(mark.begin(), mark.end(), place);
    ASSERT_TRUE(still_there(place, mark));
    delete piece;
    EXPECT_FALSE(still_there(place, mark)) << bytes;
    delete neighbour;
  }
}

}  // namespace
}  // namespace diaphane::service
