#include "renderd/encode/tile_source.h"

#include <optional>

#include "common/log.h"

namespace diaphane::render {

TileSource::TileSource(EncodePool& pool, PictureRgb8 picture, std::function<void()> ready)
    : pool_(pool),
      picture_(std::move(picture)),
      tiles_(plan_tiles(picture_.size)),
      ready_(std::move(ready)) {}

std::shared_ptr<const CodedTile> TileSource::get(std::size_t index, v1::StillFormat format) {
  const std::lock_guard lock(mutex_);
  if (index >= tiles_.size() || failed_) return nullptr;
  const Key key{format, index};
  if (const auto found = coded_.find(key); found != coded_.end()) return found->second;
  if (under_way_.insert(key).second) {
    pool_.post(EncodePool::Urgency::kLater, [weak = weak_from_this(), key] {
      if (const auto self = weak.lock()) self->code(key);
    });
  }
  return nullptr;
}

bool TileSource::failed() const {
  const std::lock_guard lock(mutex_);
  return failed_;
}

void TileSource::code(const Key& key) {
  auto coded = encode_tile(picture_, tiles_[key.second], key.first);
  if (!coded) log::error("tile_failed", {{"code", to_string(coded.error().code)}});
  {
    const std::lock_guard lock(mutex_);
    under_way_.erase(key);
    if (coded) {
      coded_[key] = std::make_shared<const CodedTile>(std::move(*coded));
    } else {
      failed_ = true;
    }
  }
  ready_();
}

}  // namespace diaphane::render
