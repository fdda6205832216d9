#pragma once

#include <memory>
#include <string>

#include "common/result.h"
#include "renderd/kernel/features.h"

// The NVIDIA run-time compiler (NVRTC), which is loaded dynamically if it is installed. Diaphane
// also starts without it. The compiler needs no device.

namespace diaphane::render::cuda {

/// A kernel template over feature sets. A new kernel needs a header with the template (`template
/// <std::uint32_t Bits> __global__`) that both nvcc and NVRTC accept, and the instances that the
/// program contains.
struct KernelTemplate {
  /// An instance that was compiled ahead of time and has at least the features `needed`.
  struct Instance {
    const void* entry;  ///< address of the __global__ function
    Features features;
  };
  const char* name;        ///< name of the source in the compiler's messages
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
  /// Loads version 13 or 12 of the library from the file or folder in DIAPHANE_NVRTC. If this is
  /// not set, tries the search path of the loader and then the toolkit of the build. Fails with
  /// kUnavailable if no library is found or its version is not supported.
  static Result<std::shared_ptr<const Nvrtc>> load();

  /// Returns the version of the compiler, for example "13.0".
  const std::string& version() const { return version_; }

  /// Compiles a kernel, which takes about a second. `architecture` is ten times the compute
  /// capability, for example 90. Thread-safe. Fails with kUnsupported if the compiler does not
  /// know the architecture, and with kInternal and the start of the compiler's output if it rejects
  /// the source.
  Result<CompiledKernel> compile(const KernelTemplate& kernel, Features features,
                                 int architecture) const;

  /// Returns a text with the options and a checksum of the sources. Together with the kernel, its
  /// features and the compiler, they determine the machine code.
  static std::string recipe(int architecture);

 private:
  struct Functions;
  Nvrtc(std::shared_ptr<const Functions> functions, std::string version)
      : functions_(std::move(functions)), version_(std::move(version)) {}

  std::shared_ptr<const Functions> functions_;
  std::string version_;
};

}  // namespace diaphane::render::cuda
