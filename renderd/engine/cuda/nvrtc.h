#pragma once

#include <memory>
#include <string>

#include "common/result.h"
#include "renderd/kernel/features.h"

// The NVIDIA compiler, loaded at run time if it is installed. Diaphane starts without it. It needs
// no device and compiles wherever the library is.

namespace diaphane::render::cuda {

/// A kernel template over feature sets. A new kernel needs a header that both compilers accept,
/// which contains the template (`template <std::uint32_t Bits> __global__`), and the instances that
/// the program contains.
struct KernelTemplate {
  /// An instance that was compiled ahead of time and has at least the features `needed`.
  struct Instance {
    const void* entry;  ///< address of the __global__ function
    Features features;
  };
  const char* name;        ///< for reports and the cache
  const char* header;      ///< the name in `#include`
  const char* expression;  ///< qualified, without arguments: "diaphane::render::cuda::trace_kernel"
  Instance (*ahead_of_time)(Features needed);
};

/// The machine code of one instance.
struct CompiledKernel {
  std::string code;    ///< cubin
  std::string symbol;  ///< mangled name of the kernel in the code
};

class Nvrtc {
 public:
  /// Loads version 13 or 12 of the library. Tries, in this order, the file or folder in
  /// DIAPHANE_NVRTC, the search path of the loader, and the toolkit of the build. Fails with
  /// kUnavailable and a list of the attempts.
  static Result<std::shared_ptr<const Nvrtc>> load();

  /// "13.0"
  const std::string& version() const { return version_; }

  /// Compiles a kernel, which takes about a second. `architecture` is ten times the compute
  /// capability, for example 90. May be called on any thread. Fails with kUnsupported if the
  /// compiler does not know the architecture, and with kInternal and its first lines of output if
  /// it rejects the source.
  Result<CompiledKernel> compile(const KernelTemplate& kernel, Features features,
                                 int architecture) const;

  /// Returns the options and sources, which together with the kernel, its features and the compiler
  /// determine the machine code.
  static std::string recipe(int architecture);

 private:
  struct Functions;
  Nvrtc(std::shared_ptr<const Functions> functions, std::string version)
      : functions_(std::move(functions)), version_(std::move(version)) {}

  std::shared_ptr<const Functions> functions_;
  std::string version_;
};

}  // namespace diaphane::render::cuda
