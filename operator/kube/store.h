#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "operator/kube/watch.h"

namespace diaphane::kube {

/// What a watched kind looks like now, as far as it was told. `T` has `name`, `uid` and `version`.
/// Thread-safe.
template <typename T>
class Store {
 public:
  /// All of them, as listed at `version`.
  void replace(std::vector<T> all, std::string version) {
    const std::lock_guard lock(mutex_);
    objects_.clear();
    for (T& one : all) {
      std::string name = one.name;
      objects_.insert_or_assign(std::move(name), std::move(one));
    }
    version_ = std::move(version);
    listed_ = true;
  }
  void changed(T object) {
    const std::lock_guard lock(mutex_);
    version_ = object.version;
    put(std::move(object));
  }
  void deleted(const std::string& name, std::string version) {
    const std::lock_guard lock(mutex_);
    objects_.erase(name);
    version_ = std::move(version);
  }
  /// Nothing changed up to there.
  void bookmark(std::string version) {
    const std::lock_guard lock(mutex_);
    version_ = std::move(version);
  }
  /// The answer to a write of ours, which the watch tells later. What the watch has gone past it
  /// has told already, and may since have told the end of.
  void wrote(T object) {
    const std::lock_guard lock(mutex_);
    if (!listed_ || compare_versions(object.version, version_) <= 0) return;
    put(std::move(object));
  }

  std::vector<T> all() const {
    const std::lock_guard lock(mutex_);
    std::vector<T> all;
    all.reserve(objects_.size());
    for (const auto& [name, one] : objects_) all.push_back(one);
    return all;
  }
  std::optional<T> find(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(name);
    return found == objects_.end() ? std::nullopt : std::optional<T>(found->second);
  }
  bool listed() const {
    const std::lock_guard lock(mutex_);
    return listed_;
  }
  std::string version() const {
    const std::lock_guard lock(mutex_);
    return version_;
  }

 private:
  void put(T object) {
    const auto found = objects_.find(object.name);
    if (found == objects_.end()) {
      std::string name = object.name;
      objects_.emplace(std::move(name), std::move(object));
    } else if (compare_versions(object.version, found->second.version) >= 0) {
      found->second = std::move(object);
    }
  }

  mutable std::mutex mutex_;
  std::map<std::string, T> objects_;
  std::string version_;
  bool listed_ = false;
};

}  // namespace diaphane::kube
