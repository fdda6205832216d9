#pragma once

#include <span>
#include <string_view>

namespace diaphane::render::cuda {

/// A source file of the kernels, with its contents at build time.
struct KernelSourceFile {
  const char* name;  ///< the name in `#include`
  const char* text;
};

/// Returns all headers that a kernel can include. cmake/EmbedSources.cmake generates the code.
std::span<const KernelSourceFile> kernel_sources();

}  // namespace diaphane::render::cuda
