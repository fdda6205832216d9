#include "renderd/engine/cuda/kernel_cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "common/fd.h"
#include "renderd/engine/cuda/checksum.h"

namespace diaphane::render::cuda {
namespace {

namespace fs = std::filesystem;

/// A file consists of kMagic, the checksum of the rest, and then key, symbol and code, each after
/// its length. Numbers have the byte order of this machine.
constexpr std::string_view kMagic = "diaphane kernel 1\n";
constexpr std::size_t kLargestFile = 64 << 20;
constexpr const char* kSuffix = ".cubin";

void append(std::string& to, std::uint64_t number) {
  std::array<char, sizeof number> bytes{};
  std::memcpy(bytes.data(), &number, sizeof number);
  to.append(bytes.data(), bytes.size());
}
void append(std::string& to, std::string_view text) {
  append(to, static_cast<std::uint64_t>(text.size()));
  to.append(text);
}

/// Removes a number from the front of `from`. Returns nothing if `from` is too short.
std::optional<std::uint64_t> take_number(std::string_view& from) {
  std::uint64_t number = 0;
  if (from.size() < sizeof number) return {};
  std::memcpy(&number, from.data(), sizeof number);
  from.remove_prefix(sizeof number);
  return number;
}
std::optional<std::string> take_text(std::string_view& from) {
  const auto size = take_number(from);
  if (!size || *size > from.size()) return {};
  std::string text(from.substr(0, *size));
  from.remove_prefix(*size);
  return text;
}

/// Returns the bytes of a file that belongs to this user or root and that only its owner can
/// change, because the bytes become code of this process. Returns nothing for any other file.
std::string read_file(const std::string& path) {
  const Fd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  // The facts must be those of the open file, because another process may replace the path at any
  // time.
  struct stat facts {};
  if (file.get() < 0 || ::fstat(file.get(), &facts) != 0 || !S_ISREG(facts.st_mode)) return {};
  if ((facts.st_uid != ::geteuid() && facts.st_uid != 0) ||
      (facts.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return {};
  }
  if (static_cast<std::uint64_t>(facts.st_size) > kLargestFile) return {};
  std::string bytes(static_cast<std::size_t>(facts.st_size), '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t some = ::read(file.get(), bytes.data() + done, bytes.size() - done);
    if (some <= 0) return {};
    done += static_cast<std::size_t>(some);
  }
  return bytes;
}

void forget_the_oldest(const fs::path& directory) {
  std::error_code ignored;
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  for (const auto& entry : fs::directory_iterator(directory, ignored)) {
    if (entry.path().extension() == kSuffix) {
      files.emplace_back(entry.last_write_time(ignored), entry.path());
    }
  }
  if (files.size() <= KernelCache::kMostFiles) return;
  std::sort(files.begin(), files.end());
  files.resize(files.size() - KernelCache::kMostFiles);
  for (const auto& [time, path] : files) fs::remove(path, ignored);
}

}  // namespace

std::string KernelCache::file_of(const std::string& key) const {
  std::array<char, 17> name{};
  std::snprintf(name.data(), name.size(), "%016llx",
                static_cast<unsigned long long>(checksum(key)));
  return directory_ + "/" + name.data() + kSuffix;
}

std::optional<CompiledKernel> KernelCache::find(const std::string& key) const {
  if (directory_.empty()) return {};
  const std::string path = file_of(key);
  const std::string bytes = read_file(path);
  std::string_view left = bytes;
  if (!left.starts_with(kMagic)) return {};
  left.remove_prefix(kMagic.size());
  const auto sum = take_number(left);
  if (!sum || *sum != checksum(left)) return {};
  const auto its_key = take_text(left);
  auto symbol = take_text(left);
  auto code = take_text(left);
  if (!code || *its_key != key) return {};
  // A directory without write access still works as a cache.
  std::error_code ignored;
  fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
  return CompiledKernel{std::move(*code), std::move(*symbol)};
}

void KernelCache::keep(const std::string& key, const CompiledKernel& kernel) const {
  if (directory_.empty()) return;
  std::error_code failed;
  const bool made = fs::create_directories(directory_, failed);
  if (failed) return;
  // Processes of this user will run the code, so no other user may write to the directory.
  if (made) fs::permissions(directory_, fs::perms::owner_all, failed);
  std::string payload;
  append(payload, key);
  append(payload, kernel.symbol);
  append(payload, kernel.code);
  std::string bytes(kMagic);
  append(bytes, checksum(payload));
  bytes += payload;

  static std::atomic<unsigned> counter{0};
  const std::string path = file_of(key);
  const std::string temporary =
      path + ".new-" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file.write(bytes.data(), std::ssize(bytes));
    file.close();
    if (!file) {
      fs::remove(temporary, failed);
      return;
    }
  }
  fs::permissions(temporary, fs::perms::owner_read | fs::perms::owner_write, failed);
  fs::rename(temporary, path, failed);
  if (failed) fs::remove(temporary, failed);
  forget_the_oldest(directory_);
}

}  // namespace diaphane::render::cuda
