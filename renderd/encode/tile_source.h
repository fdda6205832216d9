#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "renderd/encode/encode_pool.h"
#include "renderd/encode/tiles.h"

namespace diaphane::render {

/// The tiles of one finished picture, each coded once for all who receive it, when the first of
/// them is about to need it. What is still to be coded is given up with the source. Thread-safe.
class TileSource : public std::enable_shared_from_this<TileSource> {
 public:
  /// `ready` is called from a coding thread, without a lock held, when a tile has been coded.
  TileSource(EncodePool& pool, PictureRgb8 picture, std::function<void()> ready);

  const std::vector<Tile>& tiles() const { return tiles_; }
  /// The tile, or null: then it is being coded, or could not be (kept in `failed`).
  std::shared_ptr<const CodedTile> get(std::size_t index, diaphane::v1::StillFormat format);
  /// A tile could not be coded: there will be no lossless end.
  bool failed() const;

 private:
  using Key = std::pair<diaphane::v1::StillFormat, std::size_t>;
  void code(const Key& key);

  EncodePool& pool_;
  const PictureRgb8 picture_;
  const std::vector<Tile> tiles_;
  const std::function<void()> ready_;
  mutable std::mutex mutex_;
  std::map<Key, std::shared_ptr<const CodedTile>> coded_;
  std::set<Key> under_way_;
  bool failed_ = false;
};

}  // namespace diaphane::render
