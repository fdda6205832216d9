#pragma once

#include <cuda_runtime_api.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <utility>

#include "renderd/engine/cuda_error.h"

namespace diaphane::render::cuda {

/// Memory on the device, freed with its owner. Contents are what was there.
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

  /// At least one element, so that a view of an empty array has an address.
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

/// A larger buffer where `buffer` cannot hold `count`, nothing where it can: what must be allocated
/// before anything is changed, so that a refusal harms nothing. Apply with `adopt`.
template <typename T>
Result<DeviceBuffer<T>> grown(const DeviceBuffer<T>& buffer, std::size_t count) {
  if (buffer.data() != nullptr && count <= buffer.capacity()) return DeviceBuffer<T>{};
  return DeviceBuffer<T>::of(count);
}
template <typename T>
void adopt(DeviceBuffer<T>& buffer, DeviceBuffer<T>&& larger) {
  if (larger.data() != nullptr) buffer = std::move(larger);
}

/// Room for `count`: nothing where there is enough. What was in a buffer that grows is lost;
/// kOutOfMemory leaves it as it was.
template <typename T>
Result<void> ensure(DeviceBuffer<T>& buffer, std::size_t count) {
  auto larger = grown(buffer, count);
  if (!larger) return tl::unexpected(larger.error());
  adopt(buffer, std::move(*larger));
  return {};
}

/// The one T of a device, there while any session holds it.
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

/// In the stream's order; `from` may be freed when this returns.
template <typename T>
Result<void> upload(const DeviceBuffer<T>& to, const T* from, std::size_t count,
                    cudaStream_t stream) {
  if (count == 0) return {};
  DIAPHANE_CUDA_TRY(
      cudaMemcpyAsync(to.data(), from, count * sizeof(T), cudaMemcpyHostToDevice, stream));
  return {};
}

/// Waits for the stream: `to` holds the data when this returns.
template <typename T>
Result<void> download(T* to, const DeviceBuffer<T>& from, std::size_t count, cudaStream_t stream) {
  DIAPHANE_CUDA_TRY(
      cudaMemcpyAsync(to, from.data(), count * sizeof(T), cudaMemcpyDeviceToHost, stream));
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream));
  return {};
}

/// As download(), of a whole picture: by way of memory that the device writes itself, several times
/// as fast as into what was given.
Result<void> read_back(std::uint8_t* to, const std::uint8_t* from, std::size_t bytes,
                       cudaStream_t stream);

template <typename T>
Result<void> zero(const DeviceBuffer<T>& buffer, std::size_t count, cudaStream_t stream) {
  DIAPHANE_CUDA_TRY(cudaMemsetAsync(buffer.data(), 0, count * sizeof(T), stream));
  return {};
}

/// A stream of its own: what one renderer does neither waits for another's work nor holds it up.
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
  /// `urgent`: its kernels begin before those that other streams have waiting.
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
