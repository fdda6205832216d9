#include "renderd/engine/cuda/nvrtc.h"

#include <dlfcn.h>
#include <nvrtc.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <type_traits>
#include <vector>

#include "renderd/engine/cuda/checksum.h"
#include "renderd/engine/cuda/kernel_sources.h"

namespace diaphane::render::cuda {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLibraries[] = {"libnvrtc.so.13", "libnvrtc.so.12"};
/// Maximum number of bytes of the compiler's output in an error, enough to show the first errors.
constexpr std::size_t kLongestMessage = 600;

std::vector<std::string> options_for(int architecture) {
  // These options match those of nvcc for kernels ahead of time: the same optimisation, contraction
  // and line tables. The last option is for lambdas, which are not marked __device__.
  std::vector<std::string> options{"--gpu-architecture=sm_" + std::to_string(architecture),
                                   "--std=c++20", "--generate-line-info",
                                   "--device-as-default-execution-space"};
  // Allows changing a kernel's parameters without a rebuild, for example
  // "-DDIAPHANE_LIGHT_REFILL=16".
  if (const char* more = std::getenv("DIAPHANE_NVRTC_OPTIONS")) {
    std::istringstream words(more);
    for (std::string word; words >> word;) options.push_back(word);
  }
  return options;
}

/// Loads the library of built-in headers. The compiler opens it by name alone, which works only if
/// it is on the loader's search path or is already loaded.
void load_builtins(const fs::path& folder) {
  std::error_code ignored;
  for (const auto& file : fs::directory_iterator(folder, ignored)) {
    if (file.path().filename().string().starts_with("libnvrtc-builtins.so.")) {
      ::dlopen(file.path().c_str(), RTLD_NOW | RTLD_GLOBAL);
    }
  }
}

/// Opens the library in `folder`, or on the loader's search path if `folder` is empty.
void* open_in(const std::string& folder) {
  if (!folder.empty()) load_builtins(folder);
  for (const char* name : kLibraries) {
    const std::string file = folder.empty() ? name : folder + "/" + name;
    if (void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) return library;
  }
  return nullptr;
}

void* open_library() {
  const char* chosen = std::getenv("DIAPHANE_NVRTC");
  if (chosen != nullptr && *chosen != '\0') {
    if (fs::is_directory(chosen)) return open_in(chosen);
    load_builtins(fs::path(chosen).parent_path());
    return ::dlopen(chosen, RTLD_NOW | RTLD_LOCAL);
  }
  if (void* library = open_in({})) return library;
  return open_in(DIAPHANE_CUDA_LIBRARIES);
}

}  // namespace

/// The functions of the library, which is never unloaded, because it keeps state.
struct Nvrtc::Functions {
  decltype(&nvrtcVersion) version;
  decltype(&nvrtcGetErrorString) error_string;
  decltype(&nvrtcCreateProgram) create;
  decltype(&nvrtcDestroyProgram) destroy;
  decltype(&nvrtcAddNameExpression) add_name;
  decltype(&nvrtcCompileProgram) compile;
  decltype(&nvrtcGetProgramLogSize) log_size;
  decltype(&nvrtcGetProgramLog) log;
  decltype(&nvrtcGetLoweredName) lowered_name;
  decltype(&nvrtcGetCUBINSize) code_size;
  decltype(&nvrtcGetCUBIN) code;

  /// Returns false if a function is missing.
  bool find(void* library) {
    const auto find_one = [library](auto& function, const char* name) {
      function =
          reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(library, name));
      return function != nullptr;
    };
    return find_one(version, "nvrtcVersion") && find_one(error_string, "nvrtcGetErrorString") &&
           find_one(create, "nvrtcCreateProgram") && find_one(destroy, "nvrtcDestroyProgram") &&
           find_one(add_name, "nvrtcAddNameExpression") &&
           find_one(compile, "nvrtcCompileProgram") &&
           find_one(log_size, "nvrtcGetProgramLogSize") && find_one(log, "nvrtcGetProgramLog") &&
           find_one(lowered_name, "nvrtcGetLoweredName") &&
           find_one(code_size, "nvrtcGetCUBINSize") && find_one(code, "nvrtcGetCUBIN");
  }

  std::string messages(nvrtcProgram program) const {
    std::size_t size = 0;
    if (log_size(program, &size) != NVRTC_SUCCESS || size == 0) return {};
    std::string text(size, '\0');
    if (log(program, text.data()) != NVRTC_SUCCESS) return {};
    text.resize(std::min(size - 1, kLongestMessage));
    return text;
  }
};

Result<std::shared_ptr<const Nvrtc>> Nvrtc::load() {
  void* library = open_library();
  if (library == nullptr) {
    return fail(ErrorCode::kUnavailable,
                "the run-time compiler (libnvrtc.so.13 or .12) was not found, so the general "
                "kernels are used");
  }
  auto functions = std::make_shared<Functions>();
  int major = 0, minor = 0;
  if (!functions->find(library) || functions->version(&major, &minor) != NVRTC_SUCCESS) {
    return fail(ErrorCode::kUnavailable,
                "the run-time compiler that was found is not a supported version of NVRTC");
  }
  return std::shared_ptr<const Nvrtc>(
      new Nvrtc(std::move(functions), std::to_string(major) + "." + std::to_string(minor)));
}

std::string Nvrtc::recipe(int architecture) {
  static const std::uint64_t sources = [] {
    std::uint64_t sum = kChecksumStart;
    for (const KernelSourceFile& file : kernel_sources()) {
      sum = checksum(file.text, checksum(file.name, sum));
    }
    return sum;
  }();
  std::string text = "sources " + std::to_string(sources) + "\noptions";
  for (const std::string& option : options_for(architecture)) text += " " + option;
  return text + "\n";
}

Result<CompiledKernel> Nvrtc::compile(const KernelTemplate& kernel, Features features,
                                      int architecture) const {
  const Functions& f = *functions_;
  std::vector<const char*> names, texts;
  for (const KernelSourceFile& file : kernel_sources()) {
    names.push_back(file.name);
    texts.push_back(file.text);
  }
  const std::string source = "#include \"" + std::string(kernel.header) + "\"\n";
  const std::string expression =
      std::string(kernel.expression) + "<" + std::to_string(features.bits) + "u>";
  const std::vector<std::string> options = options_for(architecture);
  std::vector<const char*> arguments;
  for (const std::string& option : options) arguments.push_back(option.c_str());

  nvrtcProgram program = nullptr;
  nvrtcResult status = f.create(&program, source.c_str(), kernel.name,
                                static_cast<int>(names.size()), texts.data(), names.data());
  if (status != NVRTC_SUCCESS) return fail(ErrorCode::kInternal, f.error_string(status));
  const auto destroy = [&f](nvrtcProgram p) { f.destroy(&p); };
  const std::unique_ptr<std::remove_pointer_t<nvrtcProgram>, decltype(destroy)> owner(program,
                                                                                      destroy);
  status = f.add_name(program, expression.c_str());
  if (status == NVRTC_SUCCESS) {
    status = f.compile(program, static_cast<int>(arguments.size()), arguments.data());
  }
  if (status == NVRTC_ERROR_INVALID_OPTION) {
    return fail(ErrorCode::kUnsupported,
                "NVRTC " + version_ + " has no code for this device: " + f.messages(program));
  }
  CompiledKernel compiled;
  const char* symbol = nullptr;
  std::size_t size = 0;
  if (status == NVRTC_SUCCESS) status = f.lowered_name(program, expression.c_str(), &symbol);
  if (status == NVRTC_SUCCESS) status = f.code_size(program, &size);
  if (status == NVRTC_SUCCESS) {
    compiled.symbol = symbol;
    compiled.code.resize(size);
    status = f.code(program, compiled.code.data());
  }
  if (status != NVRTC_SUCCESS) {
    return fail(ErrorCode::kInternal,
                std::string(f.error_string(status)) + ": " + f.messages(program));
  }
  return compiled;
}

}  // namespace diaphane::render::cuda
