#pragma once

#include <optional>
#include <string>

#include "renderd/engine/cuda/nvrtc.h"

namespace diaphane::render::cuda {

/// Stores compiled kernels in a directory of this user, so that the next process need not compile
/// them. Any number of processes may use the directory concurrently, because files are replaced
/// atomically. If a file cannot be read or written, the kernel is compiled again.
class KernelCache {
 public:
  /// An empty directory disables the cache.
  explicit KernelCache(std::string directory) : directory_(std::move(directory)) {}

  /// Returns the kernel for `key`, a text with everything that the code depends on. Returns nothing
  /// if the file does not exist, is damaged or belongs to another key.
  std::optional<CompiledKernel> find(const std::string& key) const;
  /// Stores a kernel and replaces an existing one. Removes the least recently used files beyond
  /// kMostFiles.
  void keep(const std::string& key, const CompiledKernel& kernel) const;

  static constexpr std::size_t kMostFiles = 256;

 private:
  std::string file_of(const std::string& key) const;

  std::string directory_;
};

}  // namespace diaphane::render::cuda
