#include <cstdio>
#include <cstring>

#include "ingest/cli/sample/upload.h"

namespace diaphane::sample {
namespace {

constexpr std::size_t kBlock = 512;

/// Returns a ustar header (POSIX.1-1988) with only name, mode and size set.
std::string header(std::size_t number, std::size_t size) {
  std::string block(kBlock, '\0');
  char* h = block.data();
  std::snprintf(h, 100, "%05zu.dcm", number);
  std::memcpy(h + 100, "0000644", 8);
  std::memcpy(h + 108, "0000000", 8);
  std::memcpy(h + 116, "0000000", 8);
  std::snprintf(h + 124, 12, "%011zo", size);
  std::memcpy(h + 136, "00000000000", 12);
  h[156] = '0';
  std::memcpy(h + 257, "ustar", 6);
  std::memcpy(h + 263, "00", 2);
  std::memset(h + 148, ' ', 8);
  unsigned sum = 0;
  for (const char c : block) sum += static_cast<unsigned char>(c);
  std::snprintf(h + 148, 8, "%06o", sum);  // format: six digits, NUL, space
  return block;
}

}  // namespace

Result<void> Bundle::add(const std::string& file) {
  constexpr std::size_t kMostFiles = 99999;
  constexpr std::size_t kMostBytes = std::size_t{1} << 33;  // limit of eleven octal digits
  if (files_ >= kMostFiles || file.size() >= kMostBytes) {
    return fail(ErrorCode::kTooLarge, "the bundle is too large");
  }
  bytes_ += header(++files_, file.size());
  bytes_ += file;
  bytes_.append((kBlock - file.size() % kBlock) % kBlock, '\0');
  return {};
}

std::string Bundle::finish() {
  bytes_.append(2 * kBlock, '\0');
  return std::move(bytes_);
}

}  // namespace diaphane::sample
