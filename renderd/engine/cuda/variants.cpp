#include "renderd/engine/cuda/variants.h"

#include <chrono>

#include "common/log.h"
#include "common/try.h"
#include "renderd/engine/cuda/error.h"

namespace diaphane::render::cuda {
namespace {

/// Fills in registers and local memory, which stay 0 if they cannot be read.
void describe(Variant& variant) {
  cudaFuncAttributes attributes{};
  if (cudaFuncGetAttributes(&attributes, variant.entry) != cudaSuccess) {
    cudaGetLastError();
    return;
  }
  variant.registers = attributes.numRegs;
  variant.local_bytes = attributes.localSizeBytes;
}

}  // namespace

VariantStore::VariantStore(KernelChoice choice, const std::string& cache_directory,
                           int architecture, int device)
    : choice_(choice), architecture_(architecture), device_(device), cache_(cache_directory) {
  if (choice_ != KernelChoice::kExact && choice_ != KernelChoice::kStandIn) return;
  auto nvrtc = Nvrtc::load();
  if (nvrtc) {
    nvrtc_ = std::move(*nvrtc);
  } else {
    complain(nvrtc.error().message);
  }
}

VariantStore::~VariantStore() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (worker_.joinable()) worker_.join();
  for (cudaLibrary_t library : libraries_) cudaLibraryUnload(library);
}

std::string VariantStore::note() const {
  const std::scoped_lock lock(mutex_);
  return note_;
}

void VariantStore::complain(const std::string& why) {
  {
    const std::scoped_lock lock(mutex_);
    if (!note_.empty()) return;  // reported only once
    note_ = why;
  }
  // A command prints the note in its report, but a server only has its log.
  if (choice_ == KernelChoice::kStandIn) log::warning("kernels_not_compiled", {{"message", why}});
}

std::shared_ptr<const Variant> VariantStore::ahead_of_time(const KernelTemplate& kernel,
                                                           Features needed) {
  if (choice_ == KernelChoice::kGeneral) needed = kAllFeatures;
  const KernelTemplate::Instance instance = kernel.ahead_of_time(needed);
  std::shared_ptr<const Variant>& known = ahead_[Key{&kernel, instance.features.bits}];
  if (!known) {
    auto made = std::make_shared<Variant>();
    made->entry = instance.entry;
    made->features = instance.features;
    made->origin =
        instance.features == kAllFeatures ? KernelOrigin::kGeneral : KernelOrigin::kAheadOfTime;
    describe(*made);
    known = std::move(made);
  }
  return known;
}

std::shared_ptr<const Variant> VariantStore::get(const KernelTemplate& kernel, Features needed) {
  std::unique_lock lock(mutex_);
  if (nvrtc_ == nullptr) return ahead_of_time(kernel, needed);
  const Key key{&kernel, needed.bits};
  if (exact_.try_emplace(key).second) {
    queue_.push_back(key);
    if (!worker_.joinable()) worker_ = std::thread([this] { work(); });
    changed_.notify_all();
  }
  if (choice_ == KernelChoice::kExact) {
    changed_.wait(lock, [&] { return exact_[key].ended; });
  }
  const Entry& entry = exact_[key];
  return entry.variant ? entry.variant : ahead_of_time(kernel, needed);
}

void VariantStore::work() {
  // Without this call, the thread would create a context on device 0.
  cudaSetDevice(device_);
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ending_ || !queue_.empty(); });
    if (ending_) return;
    // The newest request comes first, because a user is viewing that scene now.
    const Key key = queue_.back();
    queue_.pop_back();
    lock.unlock();
    auto made = make(key);
    if (!made) complain(made.error().message);
    lock.lock();
    exact_[key] = {made ? std::move(*made) : nullptr, true};
    changed_.notify_all();
  }
}

std::string VariantStore::cache_key(const Key& key) const {
  int driver = 0;
  if (cudaDriverGetVersion(&driver) != cudaSuccess) cudaGetLastError();
  return "kernel " + std::string(key.kernel->expression) + "\nfeatures " +
         std::to_string(key.features) + "\nnvrtc " + nvrtc_->version() + "\ndriver " +
         std::to_string(driver) + "\narchitecture " + std::to_string(architecture_) + "\n" +
         Nvrtc::recipe(architecture_);
}

Result<std::shared_ptr<const Variant>> VariantStore::make(const Key& key) {
  const auto start = std::chrono::steady_clock::now();
  auto variant = std::make_shared<Variant>();
  variant->features = Features{key.features};
  variant->origin = KernelOrigin::kForThisScene;
  const std::string cached_as = cache_key(key);
  auto found = cache_.find(cached_as);
  variant->from_cache = found.has_value();
  if (!found) {
    auto compiled = nvrtc_->compile(*key.kernel, variant->features, architecture_);
    DIAPHANE_TRY(compiled);
    cache_.keep(cached_as, *compiled);
    found = std::move(*compiled);
  }
  cudaLibrary_t library = nullptr;
  DIAPHANE_CUDA_TRY(
      cudaLibraryLoadData(&library, found->code.data(), nullptr, nullptr, 0, nullptr, nullptr, 0));
  {
    const std::scoped_lock lock(mutex_);
    libraries_.push_back(library);
  }
  cudaKernel_t kernel = nullptr;
  DIAPHANE_CUDA_TRY(cudaLibraryGetKernel(&kernel, library, found->symbol.c_str()));
  variant->entry = kernel;
  describe(*variant);
  variant->milliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return variant;
}

}  // namespace diaphane::render::cuda
