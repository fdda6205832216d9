#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "operator/kube/watch.h"

namespace diaphane::kube {

/// The current objects of a watched kind, as last reported. `T` has `name`, `uid` and `version`,
/// and `equal_except_version(a, b)` says whether two objects differ only in their version.
/// Thread-safe.
template <typename T>
class Store {
 public:
  /// Replaces all objects by a list at `version`.
  void replace(std::vector<T> all, std::string version) {
    const std::lock_guard lock(mutex_);
    objects_.clear();
    for (T& one : all) {
      std::string name = one.name;
      objects_.insert_or_assign(std::move(name), std::move(one));
    }
    version_ = std::move(version);
    listed_ = true;
    ++revision_;
  }
  /// Stores an object. Like deleted() and apply_own_write(), returns whether more than the version
  /// changed.
  bool changed(T object) {
    const std::lock_guard lock(mutex_);
    version_ = object.version;
    return put(std::move(object));
  }
  bool deleted(const std::string& name, std::string version) {
    const std::lock_guard lock(mutex_);
    version_ = std::move(version);
    if (objects_.erase(name) == 0) return false;
    ++revision_;
    return true;
  }
  /// Records that nothing changed up to `version`.
  void bookmark(std::string version) {
    const std::lock_guard lock(mutex_);
    version_ = std::move(version);
  }
  /// Stores the answer to a write of this operator before the watch reports it. Ignores versions
  /// that the watch has passed, because the object may have been deleted since.
  bool apply_own_write(T object) {
    const std::lock_guard lock(mutex_);
    if (!listed_ || compare_versions(object.version, version_) <= 0) return false;
    return put(std::move(object));
  }

  /// Passes all objects to `take`, by name.
  template <typename Take>
  void visit(const Take& take) const {
    const std::lock_guard lock(mutex_);
    take(objects_);
  }
  /// Like visit, but only if anything changed since revision `known_revision`, which is then
  /// updated.
  template <typename Take>
  bool newer(std::uint64_t& known_revision, const Take& take) const {
    const std::lock_guard lock(mutex_);
    if (revision_ == known_revision) return false;
    known_revision = revision_;
    take(objects_);
    return true;
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
  bool put(T object) {
    const auto found = objects_.find(object.name);
    if (found == objects_.end()) {
      std::string name = object.name;
      objects_.emplace(std::move(name), std::move(object));
      ++revision_;
      return true;
    }
    if (compare_versions(object.version, found->second.version) <= 0) return false;
    const bool news = !equal_except_version(object, found->second);
    found->second = std::move(object);
    ++revision_;
    return news;
  }

  mutable std::mutex mutex_;
  std::map<std::string, T> objects_;
  std::string version_;
  std::uint64_t revision_ = 1;  ///< increases with each change of the contents
  bool listed_ = false;
};

}  // namespace diaphane::kube
