#pragma once

#include <span>
#include <string_view>

namespace diaphane::render::cuda {

/// A source file of the kernels, as it was when this program was built.
struct KernelSourceFile {
  const char* name;  ///< as `#include` names it
  const char* text;
};

/// All headers that a kernel can include (cmake/EmbedSources.cmake writes this function).
std::span<const KernelSourceFile> kernel_sources();

}  // namespace diaphane::render::cuda
