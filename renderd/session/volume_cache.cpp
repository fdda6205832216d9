#include "renderd/session/volume_cache.h"

#include <algorithm>
#include <new>
#include <utility>

#include "volume/store.h"

namespace diaphane::render {

VolumeCache::VolumeCache(Load load, std::uint64_t bound, unsigned threads, Stored stored)
    : load_(std::move(load)), stored_(std::move(stored)), bound_(bound) {
  for (unsigned i = 0; i < std::max(threads, 1U); ++i) threads_.emplace_back([this] { work(); });
}

VolumeCache::~VolumeCache() {
  std::vector<Ready> abandoned;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (const VolumeKey& key : queue_) {
      for (Ready& ready : entries_[key].waiting) abandoned.push_back(std::move(ready));
      entries_.erase(key);
    }
    queue_.clear();
  }
  work_ready_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  for (const Ready& ready : abandoned) {
    ready(fail(ErrorCode::kUnavailable, "This rendering server is shutting down."));
  }
}

bool VolumeCache::is_outdated(const std::string& id, const Handle& copy) const {
  if (!stored_) return false;
  const auto now = stored_(id);
  return now && *now != volume::version_of(copy->header());
}

bool VolumeCache::forget(const VolumeKey& key, const Handle& copy) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end() || found->second.volume != copy) return false;
  bytes_ -= copy->device_bytes();
  entries_.erase(found);
  return true;
}

std::vector<VolumeCache::Outdated> VolumeCache::forget_outdated() {
  std::vector<std::pair<VolumeKey, Handle>> copies;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [key, entry] : entries_) {
      if (entry.volume) copies.emplace_back(key, entry.volume);
    }
  }
  std::vector<Outdated> forgotten;
  for (const auto& [key, copy] : copies) {
    // The store is queried without the lock, because a disk may be slow.
    const auto now = stored_ ? stored_(key.id) : std::nullopt;
    const volume::Header& header = copy->header();
    if (!now || *now == volume::version_of(header) || !forget(key, copy)) continue;
    const bool only_labels = !now->empty() && now->substr(0, now->find(' ')) == header.content_hash;
    // The copies of a volume, such as its phases, are neighbours in the map.
    if (forgotten.empty() || forgotten.back().id != key.id) {
      forgotten.push_back({key.id, only_labels});
    }
  }
  return forgotten;
}

void VolumeCache::forget_unused() {
  std::vector<Handle> unused;  // freed outside the lock
  const std::lock_guard lock(mutex_);
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    Handle& volume = entry->second.volume;
    if (!volume || volume.use_count() != 1) {
      ++entry;
      continue;
    }
    bytes_ -= volume->device_bytes();
    unused.push_back(std::move(volume));
    entry = entries_.erase(entry);
  }
}

void VolumeCache::get(const VolumeKey& key, Ready ready) {
  Handle copy;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = entries_.find(key); found != entries_.end()) copy = found->second.volume;
  }
  if (copy && is_outdated(key.id, copy)) forget(key, copy);
  copy.reset();
  Handle present;
  {
    const std::lock_guard lock(mutex_);
    const auto [found, is_new] = entries_.try_emplace(key);
    Entry& entry = found->second;
    entry.used = ++turn_;
    if (!entry.volume) {
      entry.waiting.push_back(std::move(ready));
      if (is_new) {
        queue_.push_back(key);
        work_ready_.notify_one();
      }
      return;
    }
    present = entry.volume;
  }
  ready(std::move(present));
}

VolumeCache::Handle VolumeCache::find(const VolumeKey& key) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end() || !found->second.volume) return nullptr;
  found->second.used = ++turn_;
  return found->second.volume;
}

bool VolumeCache::fits(const std::string& id, std::uint64_t bytes) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t kept = bytes;
  for (const auto& [key, entry] : entries_) {
    if (key.id == id || !entry.volume || entry.volume.use_count() == 1) continue;
    kept += entry.volume->device_bytes();
  }
  return kept <= bound_;
}

Result<VolumeCache::Handle> VolumeCache::load_safely(const VolumeKey& key) {
  try {
    return load_(key);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "There is not enough memory for this scan.");
  }
}

// Requires the lock. Returns whether `needed` more bytes fit.
bool VolumeCache::make_room(std::uint64_t needed) {
  while (bytes_ + needed > bound_) {
    auto oldest = entries_.end();
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      // Only this cache holds it, and others can get it only through the lock.
      if (!entry->second.volume || entry->second.volume.use_count() != 1) continue;
      if (oldest == entries_.end() || entry->second.used < oldest->second.used) oldest = entry;
    }
    if (oldest == entries_.end()) return false;
    bytes_ -= oldest->second.volume->device_bytes();
    entries_.erase(oldest);
  }
  return true;
}

void VolumeCache::work() {
  for (;;) {
    VolumeKey key;
    {
      std::unique_lock lock(mutex_);
      work_ready_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
      if (queue_.empty()) return;
      key = std::move(queue_.front());
      queue_.pop_front();
    }
    Result<Handle> volume = load_safely(key);
    std::vector<Ready> waiting;
    {
      const std::lock_guard lock(mutex_);
      ++loads_;
      const auto entry = entries_.find(key);
      waiting = std::move(entry->second.waiting);
      if (volume && !make_room((*volume)->device_bytes())) {
        volume = fail(ErrorCode::kOutOfMemory,
                      "The memory of this rendering server is full of scans that are in use.");
      }
      if (volume) {
        entry->second.volume = *volume;
        bytes_ += (*volume)->device_bytes();
      } else {
        entries_.erase(entry);
      }
    }
    for (const Ready& ready : waiting) ready(volume);
  }
}

std::vector<std::string> VolumeCache::loaded() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  for (const auto& [key, entry] : entries_) {
    if (entry.volume && (ids.empty() || ids.back() != key.id)) ids.push_back(key.id);
  }
  return ids;
}

std::uint64_t VolumeCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::uint64_t VolumeCache::loads() const {
  const std::lock_guard lock(mutex_);
  return loads_;
}

}  // namespace diaphane::render
