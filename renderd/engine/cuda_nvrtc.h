#pragma once

#include <memory>
#include <string>

#include "common/result.h"
#include "renderd/kernel/features.h"

// NVIDIA's compiler at run time, loaded when it is there: nothing of Diaphane needs it to start.
// Knows no device: it compiles wherever the library is.

namespace diaphane::render::cuda {

/// A kernel template over feature sets. Adding a kernel is adding one of these: a header that both
/// compilers take, the template in it (`template <std::uint32_t Bits> __global__`), and the
/// instances that are in the program.
struct KernelTemplate {
  /// Of an instance that was compiled ahead of time, with all that `needed` has.
  struct Instance {
    const void* entry;  ///< address of the __global__ function
    Features features;
  };
  const char* name;        ///< for reports and the cache
  const char* header;      ///< as `#include` names it
  const char* expression;  ///< qualified, without arguments: "diaphane::render::cuda::trace_kernel"
  Instance (*ahead_of_time)(Features needed);
};

/// Machine code of one instance.
struct CompiledKernel {
  std::string code;    ///< cubin
  std::string symbol;  ///< mangled name of the kernel in it
};

class Nvrtc {
 public:
  /// Tries, in this order: the file or folder that DIAPHANE_NVRTC names, the loader's search path,
  /// the toolkit that this program was built with. Versions 13 and 12. kUnavailable says what was
  /// tried.
  static Result<std::shared_ptr<const Nvrtc>> load();

  /// "13.0"
  const std::string& version() const { return version_; }

  /// `architecture`: ten times the compute capability (90). Takes a second or so; any thread.
  /// kUnsupported when the compiler does not know the architecture, kInternal (with its first
  /// lines) when it refuses the source.
  Result<CompiledKernel> compile(const KernelTemplate& kernel, Features features,
                                 int architecture) const;

  /// What a compilation depends on beside kernel, features and the compiler: options and sources.
  static std::string recipe(int architecture);

 private:
  struct Functions;
  Nvrtc(std::shared_ptr<const Functions> functions, std::string version)
      : functions_(std::move(functions)), version_(std::move(version)) {}

  std::shared_ptr<const Functions> functions_;
  std::string version_;
};

}  // namespace diaphane::render::cuda
