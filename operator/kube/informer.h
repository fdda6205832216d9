#pragma once

#include <atomic>
#include <functional>
#include <random>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "operator/kube/backoff.h"
#include "operator/kube/store.h"
#include "operator/kube/transport.h"
#include "operator/kube/watch.h"

namespace diaphane::kube {

/// Returns the name of an object in a store, prefixed with its namespace if that is not `home`
/// ("other/name").
std::string key_of(const nlohmann::json& object, const std::string& home);
std::string version_of(const nlohmann::json& object);

/// Lists a kind and then watches it until it is stopped. It retries failures with backoff and lists
/// again after missed events (410). Calls its sink from its own thread.
class Reflector {
 public:
  struct Sink {
    virtual ~Sink() = default;
    virtual void list_begins() = 0;
    virtual void listed(const nlohmann::json& object) = 0;
    virtual void list_ends(const std::string& version) = 0;
    /// Reports an addition, modification, deletion or bookmark.
    virtual void event(const WatchEvent& event) = 0;
  };
  struct Options {
    std::string path;      ///< path of the collection
    std::string selector;  ///< encoded query, or empty
    std::string kind;      ///< name in logs and metrics
    std::string home;      ///< namespace whose objects are named without a prefix, see key_of
    Backoff::Options backoff;
    std::chrono::seconds shortest_watch{300};  ///< duration of one watch, random between these
    std::chrono::seconds longest_watch{600};
    /// Maximum silence of a watch. The API server sends a bookmark every minute, so a longer
    /// silence means that the connection is lost.
    std::chrono::milliseconds silence{75'000};
    int page = 500;
  };
  struct Counts {
    std::atomic<std::uint64_t> lists{0}, watches{0}, failures{0}, expired{0}, silent{0}, events{0};
  };

  /// Starts the thread. Destruction waits for it, so the transport must be stopped before.
  Reflector(Options options, Transport& transport, Sink& sink);

  const Counts& counts() const { return counts_; }
  const std::string& kind() const { return options_.kind; }
  const std::string& home() const { return options_.home; }
  /// Returns whether the last list or watch succeeded.
  bool connected() const { return connected_; }

 private:
  enum class Outcome { kContinue, kListAgain, kFailed };
  void run(const std::stop_token& stop);
  Outcome list(std::string& version);
  Outcome watch(std::string& version);
  double random();

  const Options options_;
  Transport& transport_;
  Sink& sink_;
  Counts counts_;
  std::atomic<bool> connected_{false};
  std::mt19937_64 random_{std::random_device{}()};
  std::jthread thread_;  // last member, because it uses the others
};

/// A reflector and the store that it fills. `read` converts an object to a T, or returns nullopt
/// for objects without interest. `changed` is called only if the plan may differ: not for a write
/// of this operator that is already in the store, and not if only the version changed (a node's
/// heartbeat).
template <typename T>
class Informer final : private Reflector::Sink {
 public:
  using Read = std::function<std::optional<T>(const nlohmann::json&)>;
  Informer(Reflector::Options options, Transport& transport, Read read,
           std::function<void()> changed)
      : read_(std::move(read)),
        changed_(std::move(changed)),
        reflector_(std::move(options), transport, *this) {}

  Store<T>& store() { return store_; }
  const Store<T>& store() const { return store_; }
  const Reflector& reflector() const { return reflector_; }
  /// Stores the answer to a write of this operator.
  void apply_own_write(const nlohmann::json& object) {
    auto one = read_(object);
    if (one && store_.apply_own_write(std::move(*one))) changed_();
  }

 private:
  void list_begins() override { listing_.clear(); }
  void listed(const nlohmann::json& object) override {
    if (auto one = read_(object)) listing_.push_back(std::move(*one));
  }
  void list_ends(const std::string& version) override {
    store_.replace(std::move(listing_), version);
    listing_ = {};
    changed_();
  }
  void event(const WatchEvent& event) override {
    const std::string version = version_of(event.object);
    if (event.type == WatchEvent::Type::kBookmark) return store_.bookmark(version);
    auto one = event.type == WatchEvent::Type::kDeleted ? std::nullopt : read_(event.object);
    const bool news = one ? store_.changed(std::move(*one))
                          : store_.deleted(key_of(event.object, reflector_.home()), version);
    if (news) changed_();
  }

  Read read_;
  std::function<void()> changed_;
  Store<T> store_;
  std::vector<T> listing_;  // used by the reflector's thread
  Reflector reflector_;     // last member, because it calls back into this object
};

}  // namespace diaphane::kube
