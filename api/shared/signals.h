#pragma once

#include <array>
#include <functional>
#include <mutex>
#include <vector>

namespace diaphane::api {

/// An event that a service reports to a background task, which would otherwise notice it only in
/// its next poll.
enum class Signal {
  kMail,      ///< an email was queued
  kDisposal,  ///< files were queued for deletion
  kPicture,   ///< a preset may need a thumbnail
  kExport,    ///< an export was requested
  kSignOut,   ///< a browser was signed out, so its streams have to end
};

/// Connects services, which raise signals, to background tasks, which subscribe to them.
/// Thread-safe.
class Signals {
 public:
  using Listener = std::function<void()>;

  /// `listener` runs in the thread that raises the signal. Whatever it refers to must outlive the
  /// last signal.
  void subscribe(Signal signal, Listener listener);
  void raise(Signal signal) const;

 private:
  static constexpr std::size_t kSignals = static_cast<std::size_t>(Signal::kSignOut) + 1;
  mutable std::mutex mutex_;
  std::array<std::vector<Listener>, kSignals> listeners_;
};

}  // namespace diaphane::api
