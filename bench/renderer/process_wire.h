#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

// Messages between a MultiProcessEngine and its device processes, over a socket pair on one
// machine.

namespace diaphane::render::bench {

enum class ProcessMessageKind : std::uint32_t {
  kDone,
  kFailed,  ///< code and message of an error
  kInfo,
  kRenderer,
  kScene,
  kRender,
  kProgress,
  kRadiance,
  kContents,
  kFeatures
};

struct ProcessMessage {
  ProcessMessageKind word = ProcessMessageKind::kDone;
  std::string payload;
};

/// One end of a connection, which owns its descriptor.
class ProcessWire {
 public:
  explicit ProcessWire(int descriptor) : descriptor_(descriptor) {}
  ~ProcessWire();
  ProcessWire(ProcessWire&& other) noexcept : descriptor_(other.descriptor_) {
    other.descriptor_ = -1;
  }
  ProcessWire& operator=(ProcessWire&&) = delete;

  bool send(ProcessMessageKind word, std::string_view payload) const;
  /// Receives a message, or nullopt when the other end has closed the connection.
  std::optional<ProcessMessage> receive() const;

 private:
  int descriptor_;
};

template <typename T>
std::string packed(const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const char*>(&value), sizeof value};
}
/// Removes the value from the front of `from`.
template <typename T>
T unpacked(std::string_view& from) {
  static_assert(std::is_trivially_copyable_v<T>);
  T value{};
  std::memcpy(&value, from.data(), sizeof value < from.size() ? sizeof value : from.size());
  from.remove_prefix(sizeof value < from.size() ? sizeof value : from.size());
  return value;
}

}  // namespace diaphane::render::bench
