#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "common/try.h"
#include "renderd/engine/cuda/error.h"

namespace diaphane::render::cuda {

/// An array in device memory, which is not initialised and which the destructor frees.
template <typename T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  DeviceBuffer(DeviceBuffer&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), capacity_(std::exchange(other.capacity_, 0)) {}
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  DeviceBuffer(const DeviceBuffer&) = delete;
  DeviceBuffer& operator=(const DeviceBuffer&) = delete;
  ~DeviceBuffer() { cudaFree(data_); }

  /// Allocates `count` elements, or one if `count` is 0, so that an empty array has an address.
  static Result<DeviceBuffer> of(std::size_t count) {
    DeviceBuffer buffer;
    buffer.capacity_ = count == 0 ? 1 : count;
    DIAPHANE_CUDA_TRY(
        cudaMalloc(reinterpret_cast<void**>(&buffer.data_), buffer.capacity_ * sizeof(T)));
    return buffer;
  }

  T* data() const { return data_; }
  std::size_t capacity() const { return capacity_; }
  std::size_t bytes() const { return capacity_ * sizeof(T); }

 private:
  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

/// Returns a larger buffer if `buffer` cannot hold `count` elements, otherwise an empty one. This
/// lets a caller allocate everything before it changes anything, so that running out of memory has
/// no effect. adopt() applies the result.
template <typename T>
Result<DeviceBuffer<T>> grown(const DeviceBuffer<T>& buffer, std::size_t count) {
  if (buffer.data() != nullptr && count <= buffer.capacity()) return DeviceBuffer<T>{};
  return DeviceBuffer<T>::of(count);
}
template <typename T>
void adopt(DeviceBuffer<T>& buffer, DeviceBuffer<T>&& larger) {
  if (larger.data() != nullptr) buffer = std::move(larger);
}

/// Makes room for `count` elements. A buffer that grows loses its contents, but remains unchanged
/// if the result is kOutOfMemory.
template <typename T>
Result<void> ensure(DeviceBuffer<T>& buffer, std::size_t count) {
  auto larger = grown(buffer, count);
  DIAPHANE_TRY(larger);
  adopt(buffer, std::move(*larger));
  return {};
}

/// Provides the single T of a device, which exists while at least one session holds it.
template <typename T>
class DeviceShare {
 public:
  std::shared_ptr<T> take() {
    const std::lock_guard lock(mutex_);
    auto shared = shared_.lock();
    if (!shared) shared_ = shared = std::make_shared<T>();
    return shared;
  }

 private:
  std::mutex mutex_;
  std::weak_ptr<T> shared_;
};

/// Copies to the device in the order of the stream. `from` may be freed when this returns.
template <typename T>
Result<void> upload(const DeviceBuffer<T>& to, const T* from, std::size_t count,
                    cudaStream_t stream) {
  if (count == 0) return {};
  DIAPHANE_CUDA_TRY(
      cudaMemcpyAsync(to.data(), from, count * sizeof(T), cudaMemcpyHostToDevice, stream));
  return {};
}

/// Copies from the device and waits for the stream, so `to` holds the data when this returns.
template <typename T>
Result<void> download(T* to, const DeviceBuffer<T>& from, std::size_t count, cudaStream_t stream) {
  DIAPHANE_CUDA_TRY(
      cudaMemcpyAsync(to, from.data(), count * sizeof(T), cudaMemcpyDeviceToHost, stream));
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
  return {};
}

/// Works like download() for a whole picture. It copies through page-locked memory, which is
/// several times as fast as a copy to pageable memory.
Result<void> read_back(std::uint8_t* to, const std::uint8_t* from, std::size_t bytes,
                       cudaStream_t stream);

template <typename T>
Result<void> zero(const DeviceBuffer<T>& buffer, std::size_t count, cudaStream_t stream) {
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(buffer.data(), 0, count * sizeof(T), stream));
  return {};
}

/// A CUDA stream of one renderer, so that its work neither waits for the work of other renderers
/// nor delays it.
class Stream {
 public:
  Stream() = default;
  Stream(Stream&& other) noexcept : stream_(std::exchange(other.stream_, nullptr)) {}
  Stream& operator=(Stream&& other) noexcept {
    std::swap(stream_, other.stream_);
    return *this;
  }
  ~Stream() {
    if (stream_ != nullptr) cudaStreamDestroy(stream_);
  }
  /// Kernels of an `urgent` stream begin before the waiting kernels of other streams.
  static Result<Stream> make(bool urgent = false) {
    Stream stream;
    int least = 0, greatest = 0;
    DIAPHANE_CUDA_TRY(cudaDeviceGetStreamPriorityRange(&least, &greatest));
    DIAPHANE_CUDA_TRY(cudaStreamCreateWithPriority(&stream.stream_, cudaStreamNonBlocking,
                                                   urgent ? greatest : least));
    return stream;
  }
  cudaStream_t get() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

class Event {
 public:
  Event() = default;
  Event(Event&& other) noexcept : event_(std::exchange(other.event_, nullptr)) {}
  Event& operator=(Event&& other) noexcept {
    std::swap(event_, other.event_);
    return *this;
  }
  ~Event() {
    if (event_ != nullptr) cudaEventDestroy(event_);
  }
  static Result<Event> make() {
    Event event;
    DIAPHANE_CUDA_TRY(cudaEventCreate(&event.event_));
    return event;
  }
  cudaEvent_t get() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

}  // namespace diaphane::render::cuda
