#pragma once

#include <optional>
#include <string>

#include "renderd/engine/cuda_nvrtc.h"

namespace diaphane::render::cuda {

/// Compiled kernels in a directory of this user's, so that the next process need not compile them.
/// Any number of processes may use it at once: a file appears whole or not at all. Nothing depends
/// on it: what cannot be read or written is compiled again.
class KernelCache {
 public:
  /// Empty: keeps nothing.
  explicit KernelCache(std::string directory) : directory_(std::move(directory)) {}

  /// `key` is all that the code depends on, as text. Nothing for a file that is absent, damaged or
  /// another key's.
  std::optional<CompiledKernel> find(const std::string& key) const;
  /// Replaces what was there. Beyond kMostFiles the ones longest unused go.
  void keep(const std::string& key, const CompiledKernel& kernel) const;

  static constexpr std::size_t kMostFiles = 256;

 private:
  std::string file_of(const std::string& key) const;

  std::string directory_;
};

}  // namespace diaphane::render::cuda
